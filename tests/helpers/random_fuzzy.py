"""Random engines in FLL and systems in .fis: every norm, shape, hedge, weight and defuzzifier.

Whatever is admitted is drawn; numbers have three decimals, as people and fuzzylite write them.
"""

SHAPES = {
    "Triangle": "p p p",
    "Trapezoid": "p p p p",
    "Rectangle": "p p",
    "Ramp": "p p",
    "Gaussian": "c w",
    "GaussianProduct": "p w p w",
    "Bell": "c w 2.5",
    "Sigmoid": "c s",
    "SShape": "p p",
    "ZShape": "p p",
    "PiShape": "p p p p",
}
FIS_SHAPES = {
    "trimf": "p p p",
    "trapmf": "p p p p",
    "gaussmf": "w c",
    "gauss2mf": "w p w p",
    "gbellmf": "w 2 c",
    "sigmf": "s c",
    "psigmf": "s c s c",
    "dsigmf": "10 p 10 p",
    "smf": "p p",
    "zmf": "p p",
    "pimf": "p p p p",
}
HEDGES = ["not", "very", "somewhat", "extremely", "seldom"]
INTEGRALS = ["Centroid", "Bisector", "MeanOfMaximum", "SmallestOfMaximum", "LargestOfMaximum"]


def numbers(random, pattern, low, high, upright=0.0):
    """Of places that rise, centres, widths and slopes within a range."""
    count, width = pattern.split().count("p"), high - low
    corners = sorted(random.sample([low + width * k / 40 for k in range(-8, 49)], count))
    if count == 3 and random.random() < upright:
        corners[random.choice([0, 2])] = corners[1]
    drawn = {
        "p": lambda: corners.pop(0),
        "c": lambda: random.uniform(low, high),
        "w": lambda: random.uniform(0.1, 0.6) * width,
        "s": lambda: random.choice([-1, 1]) * random.uniform(3.0, 15.0) / width,
    }
    found = [drawn[part]() if part in drawn else float(part) for part in pattern.split()]
    return [f"{number:.3f}" for number in found]


def drawn_range(random):
    low = random.choice([-40.0, -1.0, 0.0, 2.5])
    return low, low + random.choice([0.5, 2.0, 60.0])


def fll(random):
    """The text of an engine."""
    sides, lines = [], ["Engine: drawn"]
    for name in ("x", "y"):
        low, high = drawn_range(random)
        lines += [f"InputVariable: {name}", f"  range: {low} {high}"]
        lines += [f"  lock-range: {random.choice(['true', 'false'])}"]
        sides.append([f"{name}{k}" for k in range(random.randint(2, 4))])
        for term in sides[-1]:
            kind = random.choice([*SHAPES])
            corners = numbers(random, SHAPES[kind], low, high, upright=0.3)
            if kind == "Ramp" and random.random() < 0.5:
                corners.reverse()
            if kind == "Trapezoid" and random.random() < 0.3:
                corners[:2] = ["-inf", "-inf"] if random.random() < 0.5 else ["-inf", corners[1]]
            lines.append(f"  term: {term} {kind} {' '.join(corners)}")
    low, high = drawn_range(random)
    aggregation = random.choice(["Maximum", "AlgebraicSum", "BoundedSum", "UnboundedSum"])
    lines += ["OutputVariable: z", f"  range: {low} {high}"]
    lines += [f"  lock-range: {random.choice(['true', 'false'])}"]
    lines += [f"  default: {random.choice(['nan', low - 1.0, 0.5 * (low + high)])}"]
    shaped = random.random() < 0.5
    if shaped:
        told = f"{random.choice(INTEGRALS)} {random.choice([100, 101, 200])}"
        kinds = [*SHAPES]
    else:
        kinds = random.choice([["Ramp"], ["Constant", "Linear"]])
        types = ["", " Automatic", " TakagiSugeno" if "Linear" in kinds else " Tsukamoto"]
        told = random.choice(["WeightedAverage", "WeightedSum"]) + random.choice(types)
        aggregation = random.choice([aggregation, "none"])
    lines += [f"  defuzzifier: {told}", f"  aggregation: {aggregation}"]
    patterns = SHAPES | {"Constant": "c", "Linear": random.choice(["c c c", "c c"])}
    results = [f"z{k}" for k in range(random.randint(2, 4))]
    for term in results:
        kind = random.choice(kinds)
        corners = numbers(random, patterns[kind], low, high)
        lines.append(f"  term: {term} {kind} {' '.join(corners)}")
    norms = random.choice(["Minimum", "AlgebraicProduct", "BoundedDifference"])
    lines += ["RuleBlock:", f"  conjunction: {norms}", "  activation: General"]
    lines += [f"  disjunction: {random.choice(['Maximum', 'AlgebraicSum', 'BoundedSum'])}"]
    implications = ["Minimum", "AlgebraicProduct", "BoundedDifference"] + ["none"] * (not shaped)
    lines += [f"  implication: {random.choice(implications)}"]
    for _ in range(random.randint(3, 9)):
        weight = random.choice(["", "", f" with {random.uniform(0.1, 1.0):.3f}"])
        lines.append(
            f"  rule: if {condition(random, sides)} then z is {random.choice(results)}{weight}"
        )
    return "\n".join(lines) + "\n"


def condition(random, sides, depth=0):
    """Clauses with hedges, joined and in brackets."""
    if depth == 2 or random.random() < 0.3:
        k = random.randrange(2)
        hedges = [random.choice(HEDGES) for _ in range(random.choice([0, 0, 0, 1, 2]))]
        term = "any" if random.random() < 0.05 else random.choice(sides[k])
        return " ".join(["xy"[k], "is", *hedges, term])
    parts = [condition(random, sides, depth + 1) for _ in range(2)]
    joined = f" {random.choice(['and', 'or'])} ".join(parts)
    return f"({joined})" if random.random() < 0.5 else joined


def fis(random):
    """The text of a system, Mamdani's or Sugeno's."""
    mamdani = random.random() < 0.5
    methods = {
        "And": random.choice(["min", "prod"]),
        "Or": random.choice(["max", "probor", "algebraic_sum"]),
        "Imp": random.choice(["min", "prod"]),
        "Agg": random.choice(["max", "sum", "probor"]),
        "Defuzz": random.choice(["centroid", "mom"] if mamdani else ["wtaver", "wtsum"]),
    }
    counts = [random.randint(2, 4) for _ in range(3)]
    rules = [drawn_rule(random, counts, mamdani) for _ in range(random.randint(3, 9))]
    lines = ["[System]", "Name='drawn'", f"Type='{'mamdani' if mamdani else 'sugeno'}'"]
    lines += ["Version=2.0", "NumInputs=2", "NumOutputs=1", f"NumRules={len(rules)}"]
    lines += [f"{key}Method='{name}'" for key, name in methods.items()]
    for title, name, count in zip(("Input1", "Input2", "Output1"), "xyz", counts, strict=True):
        low, high = drawn_range(random)
        lines += ["", f"[{title}]", f"Name='{name}'", f"Range=[{low} {high}]", f"NumMFs={count}"]
        sugeno = title == "Output1" and not mamdani
        patterns = {"constant": "c", "linear": "c c c"} if sugeno else FIS_SHAPES
        for k in range(1, count + 1):
            kind = random.choice([*patterns])
            corners = " ".join(numbers(random, patterns[kind], low, high))
            lines.append(f"MF{k}='{name}{k}':'{kind}',[{corners}]")
    return "\n".join([*lines, "", "[Rules]", *rules]) + "\n"


def drawn_rule(random, counts, mamdani):
    """Numbers of terms, negative for not."""
    first, second = (random.choice([-1, 1, 1]) * random.randint(0, count) for count in counts[:2])
    first = first or (0 if second else 1)
    third = random.randint(1, counts[2]) * (random.choice([-1, 1, 1]) if mamdani else 1)
    weight = random.choice(["1", "1", f"{random.uniform(0.1, 1.0):.3f}"])
    return f"{first} {second}, {third} ({weight}) : {random.choice([1, 1, 2])}"
