"""What an FLL engine is called and made of; runs in the environment of pyfuzzylite: JSON."""

import json
import sys

import fuzzylite as fl

engine = fl.FllImporter().from_file(sys.argv[1])
variables = {
    variable.name: {
        "range": [variable.minimum, variable.maximum],
        "terms": [[type(term).__name__, term.name, term.parameters()] for term in variable.terms],
    }
    for variable in (*engine.input_variables, *engine.output_variables)
}
rules = sorted(rule.text for block in engine.rule_blocks for rule in block.rules)
json.dump({"engine": engine.name, "variables": variables, "rules": rules}, sys.stdout)
