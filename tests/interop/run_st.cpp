// Runs PROGRAM main of a file of Structured Text by pyplcopen's compiler and VM, a scan a sample.
//
//     run_st FILE < rows > rows
//
// A row in has a double for each variable of main that is called in_..., and one for reset, in the
// order of their declaration; a row out has two, the variables command and fault.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "st/st.h"

using namespace plcopen::core;

int main(int argc, char **argv)
{
    if (argc != 2) return 2;
    std::ifstream file(argv[1]);
    const std::string source((std::istreambuf_iterator<char>(file)), {});
    const st::CompileResult compiled = st::compile(source);
    for (const st::Diagnostic &found : compiled.diagnostics)
        std::fprintf(stderr, "%u:%u: %s\n", unsigned(found.line), unsigned(found.column),
                     found.message.c_str());
    if (!compiled.ok) return 1;
    const st::Program &program = compiled.program;
    std::vector<std::uint64_t> memory(program.required_bytes() / 8 + 1);
    unsigned char *const variables = reinterpret_cast<unsigned char *>(memory.data());
    st::Instance instance;
    if (instance.load(program, variables, memory.size() * 8, 1000000) != rt::ErrorCode::ok) return 1;
    std::vector<std::size_t> inputs;
    for (const st::VarInfo &one : program.vars)
        if (one.lower.rfind("in_", 0) == 0) inputs.push_back(one.offset);
    const std::size_t command = std::size_t(instance.find("command"));
    const std::size_t fault = std::size_t(instance.find("fault"));
    std::vector<double> row(inputs.size());
    while (std::fread(row.data(), sizeof(double), row.size(), stdin) == row.size()) {
        for (std::size_t k = 0; k < row.size(); ++k)
            std::memcpy(variables + inputs[k], &row[k], sizeof(double));
        const st::ScanError error = instance.scan(10000000);
        if (error != st::ScanError::ok) {
            std::fprintf(stderr, "scan: %s\n", st::to_string(error));
            return 1;
        }
        const double out[] = {instance.value_f64(command), double(instance.value_bool(fault))};
        std::fwrite(out, sizeof out, 1, stdout);
    }
    return 0;
}
