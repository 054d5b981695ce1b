/* Steps through the samples. Puts out the commands, then by how much the stack has grown [bytes] and
 * how often the clock ticked at most while a step was made. */
#include "board.h"
#include "step.h"

enum { PAINTED = 2048, PAINT = 0x5a5a5a5a }; /* words of the stack */

__asm__(".section .rodata.samples, \"a\"\n"
        ".balign 8\n"
        "samples: .incbin \"samples.bin\"\n"
        "samples_end: .previous");
extern const sample samples[], samples_end[];

static state controller;
static real commands[COUNT][COMMANDS];

int main(void)
{
    volatile uint32_t *top, *deepest;
    uint32_t told[2] = { 0, 0 };
    if (samples_end - samples != COUNT) {
        return 1;
    }
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (deepest = top - PAINTED; deepest < top; deepest++) {
        *deepest = PAINT;
    }
    begin(&controller);
    for (int k = 0; k < COUNT; k++) {
        const uint32_t before = ticks();
        step(&controller, &samples[k], commands[k]);
        const uint32_t spent = ticks() - before;
        told[1] = spent > told[1] ? spent : told[1];
    }
    for (deepest = top - PAINTED; deepest < top && *deepest == PAINT; deepest++) { }
    told[0] = (uint32_t)(top - deepest) * (uint32_t)sizeof *top;
    put(commands, sizeof commands);
    put(told, sizeof told);
    return 0;
}
