/* Loads the FMI 2.0 library of a co-simulation and prints the bits of its outputs, a line a sample.
 *
 * load_fmu LIBRARY GUID STEP SAMPLES INPUT... - OUTPUT...   (value references)
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define LOAD(path) (void *)LoadLibraryA(path)
#define FIND(library, name) (void *)GetProcAddress((HMODULE)library, name)
#else
#include <dlfcn.h>
#define LOAD(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *allocate, *release, *finished, *environment;
} Callbacks;

static void told(void *e, const char *name, int status, const char *category, const char *text, ...)
{
    (void)e, (void)name, (void)category;
    fprintf(stderr, "%d %s\n", status, text);
}

int main(int count, char **given)
{
    void *library = LOAD(given[1]);
    if (!library) {
        fprintf(stderr, "%s cannot be loaded\n", given[1]);
        return 1;
    }
    void *(*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) =
        FIND(library, "fmi2Instantiate");
    int (*setup)(void *, int, double, double, int, double) = FIND(library, "fmi2SetupExperiment");
    int (*enter)(void *) = FIND(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = FIND(library, "fmi2ExitInitializationMode");
    int (*put)(void *, const unsigned *, size_t, const double *) = FIND(library, "fmi2SetReal");
    int (*get)(void *, const unsigned *, size_t, double *) = FIND(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = FIND(library, "fmi2DoStep");
    void (*release)(void *) = FIND(library, "fmi2FreeInstance");
    const Callbacks callbacks = { told, 0, 0, 0, 0 };
    const double every = atof(given[3]);
    void *slave = instantiate("one", 1, given[2], "", &callbacks, 0, 0);
    int bad = setup(slave, 0, 0.0, 0.0, 0, 0.0) | enter(slave) | leave(slave);
    for (int k = 0; k < atoi(given[4]); k++) {
        int inputs = 1;
        for (int n = 5; n < count; n++) {
            const unsigned reference = (unsigned)atoi(given[n]);
            double value = ((37 * k + 11 * n) % 101 - 50) * 0.2;
            if (strcmp(given[n], "-") == 0) {
                inputs = 0;
                bad |= step(slave, k * every, every, 1);
            } else if (inputs) {
                bad |= put(slave, &reference, 1, &value);
            } else {
                unsigned long long bits;
                bad |= get(slave, &reference, 1, &value);
                memcpy(&bits, &value, sizeof bits);
                printf("%016llx%c", bits, n == count - 1 ? '\n' : ' ');
            }
        }
    }
    release(slave);
    return bad;
}
