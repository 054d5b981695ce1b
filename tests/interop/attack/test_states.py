"""Damaged states of FMUs: each is refused in a line that is logged, or goes on within bounds."""

import struct
import subprocess
import zipfile
from itertools import chain, product
from math import inf, nan

import pytest
from attack import FULL, Attack

from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS

#: Goes on from every state in a file; or writes one: of ten samples, with every input at 3.
DRIVER = """
#include "slave.h"
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static int logged;
#if FMI == 2
typedef struct { void *logger, *allocate, *release, *finished, *environment; } Functions;
static void tell(void *e, const char *n, int s, const char *c, const char *text, ...)
{ (void)e, (void)n, (void)s, (void)c, (void)text; logged++; }
#define OF(name) fmi2##name
void *fmi2Instantiate(const char *, int, const char *, const char *, const Functions *, int, int);
int fmi2DoStep(void *, double, double, int);
#define GET(c, r, n, x) fmi2GetReal(c, r, n, x)
#define SET(c, r, n, x) fmi2SetReal(c, r, n, x)
#define STEP(c, time) fmi2DoStep(c, time, model_every, 0)
#define BEGIN(c) fmi2EnterInitializationMode(c)
int fmi2EnterInitializationMode(void *);
int fmi2GetReal(void *, const unsigned *, size_t, double *);
int fmi2SetReal(void *, const unsigned *, size_t, const double *);
int fmi2GetFMUstate(void *, void **), fmi2FreeFMUstate(void *, void **);
int fmi2SetFMUstate(void *, void *);
int fmi2SerializeFMUstate(void *, void *, unsigned char *, size_t);
int fmi2DeSerializeFMUstate(void *, const unsigned char *, size_t, void **);
int fmi2ExitInitializationMode(void *);
void fmi2FreeInstance(void *);
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#else
static void tell(void *e, int s, const char *c, const char *text)
{ (void)e, (void)s, (void)c, (void)text; logged++; }
#define OF(name) fmi3##name
void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool,
    const unsigned *, size_t, void *, void *, void *);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);
static bool off[3]; static double last;
#define GET(c, r, n, x) fmi3GetFloat64(c, r, n, x, n)
#define SET(c, r, n, x) fmi3SetFloat64(c, r, n, x, n)
#define STEP(c, time) fmi3DoStep(c, time, model_every, false, off, off + 1, off + 2, &last)
#define BEGIN(c) fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0)
int fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3GetFloat64(void *, const unsigned *, size_t, double *, size_t);
int fmi3SetFloat64(void *, const unsigned *, size_t, const double *, size_t);
int fmi3GetFMUState(void *, void **), fmi3FreeFMUState(void *, void **);
int fmi3SetFMUState(void *, void *);
int fmi3SerializeFMUState(void *, void *, unsigned char *, size_t);
int fmi3DeserializeFMUState(void *, const unsigned char *, size_t, void **);
int fmi3ExitInitializationMode(void *);
void fmi3FreeInstance(void *);
#endif
#define NEED(what) if (!(what)) { printf("state %d: %s\\n", n, #what); return 1; }

static void inputs(void *c)
{
    const double value = 3.0;
    for (unsigned k = 0; k < VARIABLES; k++) {
        if (model_variables[k].causality == INPUT) { SET(c, &k, 1, &value); }
    }
}

int main(int count, char **files)
{
    static unsigned char bytes[sizeof(Kept)];
    unsigned clock = 0;
    int n = 0, refused = 0, stopped = 0, stepped = 0;
    void *state = NULL;
#if FMI == 2
    const Functions functions = { (void *)tell, NULL, NULL, NULL, NULL };
    void *c = fmi2Instantiate("one", 1, MODEL_TOKEN, "", &functions, 0, 0);
#else
    void *c = fmi3InstantiateCoSimulation("one", MODEL_TOKEN, "", false, false, false, false, NULL,
        0, NULL, (void *)tell, NULL);
#endif
    BEGIN(c);
    OF(ExitInitializationMode)(c);
    FILE *file = fopen(files[1], count > 2 ? "wb" : "rb");
    if (count > 2) {
        inputs(c);
        for (int k = 0; k < 10; k++) { NEED(STEP(c, k * model_every) == GOOD) }
        OF(GetFMUState)(c, &state);
        NEED(OF(SerializeFMUState)(c, state, bytes, sizeof bytes) == GOOD)
        fwrite(bytes, sizeof bytes, 1, file);
    }
    for (; count == 2 && fread(bytes, sizeof bytes, 1, file) == 1; n++) {
        const int before = logged;
        if (OF(DeserializeFMUState)(c, bytes, sizeof bytes, &state) != GOOD) {
            NEED(logged == before + 1)
            refused++;
            continue;
        }
        NEED(OF(SetFMUState)(c, state) == GOOD)
        int status = GOOD;
        for (int k = 0; k < 4; k++) {
            double time, value;
            if (k == 1) { inputs(c); }
            GET(c, &clock, 1, &time);
            const int now = STEP(c, time);
            status = now > status ? now : status;
            for (unsigned v = 0; now == GOOD && v < VARIABLES; v++) {
                if (model_variables[v].causality == OUTPUT) {
                    GET(c, &v, 1, &value);
                    NEED(isfinite(value))
                }
            }
        }
        NEED((status == GOOD) == (logged == before))
        stopped += status != GOOD;
        stepped += status == GOOD;
    }
    fclose(file);
    if (state) { OF(FreeFMUState)(c, &state); }
    OF(FreeInstance)(c);
    printf("%d %d %d\\n", refused, stopped, stepped);
    return 0;
}
"""
SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
FMUS = [("jee-koren-2004-aflc", "fmu"), ("jee-koren-2004-aflc", "fmu-loop")]
FMUS += [("lin-lee-1999-table-1", "fmu-loop"), ("huang-cross-coupled", "fmu")]
#: What a byte is changed with, and what a number is replaced by.
MASKS = range(1, 256) if FULL else (0x01, 0x10, 0x80, 0xFF)
ODD = (nan, inf, -inf, 1e300, -1e300, 1e18, -1.0, 6.5, 5e-324)


def damaged(state):
    """Every byte changed in some ways, every number that is aligned replaced by some."""
    for place, mask in product(range(len(state)), MASKS):
        yield state[:place] + bytes([state[place] ^ mask]) + state[place + 1 :]
    for place, number in product(range(0, len(state) - 7, 8), ODD):
        yield state[:place] + struct.pack("d", number) + state[place + 8 :]


@pytest.mark.parametrize(("name", "to"), FMUS)
def test_a_damaged_state_is_refused_or_goes_on(name, to, tmp_path):
    FORMATS[to].write(load_design(name), tmp_path / "fmus")
    attack = Attack(f"damaged states, {name} as {to}")
    for fmu in sorted((tmp_path / "fmus").iterdir()):
        folder = tmp_path / fmu.stem
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        (folder / "sources" / "driver.c").write_text(DRIVER)
        version, program = fmu.stem[-1], folder / "program"
        sources = sorted((folder / "sources").glob("*.c"))
        command = ["gcc", "-std=c99", "-O1", f"-DFMI={version}", *SANITIZERS, *sources, "-lm"]
        subprocess.run([*command, "-o", program], check=True)
        subprocess.run([program, folder / "good", "write"], check=True)
        good = (folder / "good").read_bytes()
        with (folder / "bad").open("wb") as file:
            file.writelines(chain([good], damaged(good)))
        done = subprocess.run(
            [program, folder / "bad"], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr[:2000]
        words = ("refused", "stopped", "stepped")
        outcomes = dict(zip(words, map(int, done.stdout.split()), strict=True))
        assert sum(outcomes.values()) == (folder / "bad").stat().st_size // len(good) > 900
        assert outcomes["refused"] > 100 < outcomes["stepped"]
        attack.outcomes.update(outcomes)
    attack.end()
