// The units of a controller as engines of the C++ library fuzzylite.
#include <fl/Headers.h>
#include <vector>

struct Machine {
    std::vector<fl::Engine *> engines;
    std::vector<int> sources;
};

extern "C" void *prepare(int units, const char **texts, const int *sources)
{
    Machine *machine = new Machine;
    for (int k = 0; k < units; k++) {
        machine->engines.push_back(fl::FllImporter().fromString(texts[k]));
        machine->sources.push_back(sources[2 * k]);
        machine->sources.push_back(sources[2 * k + 1]);
    }
    return machine;
}

extern "C" void run(void *handle, int steps, int inputs, const double *values, double *outputs)
{
    Machine *machine = static_cast<Machine *>(handle);
    const int units = static_cast<int>(machine->engines.size());
    std::vector<double> known(inputs + units);
    for (int i = 0; i < steps; i++) {
        for (int j = 0; j < inputs; j++) {
            known[j] = values[inputs * i + j];
        }
        for (int k = 0; k < units; k++) {
            fl::Engine *engine = machine->engines[k];
            engine->getInputVariable(0)->setValue(known[machine->sources[2 * k]]);
            engine->getInputVariable(1)->setValue(known[machine->sources[2 * k + 1]]);
            engine->process();
            known[inputs + k] = engine->getOutputVariable(0)->getValue();
        }
        outputs[i] = known[inputs + units - 1];
    }
}
