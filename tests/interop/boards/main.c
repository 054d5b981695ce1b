/* Steps through the samples twice: for what that takes, then for the commands, which it puts out.
 * Last are the bytes by which the stack has grown, and the ticks of the longest step. */
#include "board.h"
#include "step.h"

enum { PAINT = 0x5a };

__asm__(".section " IN_FLASH ", \"a\"\n"
        ".balign 8\n"
        "samples: .incbin \"samples.bin\"\n"
        "samples_end: .previous");
extern const sample samples[], samples_end[];

static state controller;
static sample now;

int main(void)
{
    volatile uint8_t *top, *deepest;
    uint32_t taken[2] = { 0, 0 };
    real commands[COMMANDS];
    board_begin();
    if (samples_end - samples != COUNT) {
        board_end(0);
    }
    top = STACK;
    for (deepest = FREE; deepest < top; deepest++) {
        *deepest = PAINT;
    }
    begin(&controller);
    for (int k = 0; k < COUNT; k++) {
        LOAD(now, &samples[k]);
        const ticks before = board_ticks();
        step(&controller, &now, commands);
        const ticks spent = (ticks)(board_ticks() - before);
        taken[1] = spent > taken[1] ? spent : taken[1];
    }
    for (deepest = FREE; deepest < top && *deepest == PAINT; deepest++) { }
    taken[0] = (uint32_t)(top - deepest);
    begin(&controller);
    for (int k = 0; k < COUNT; k++) {
        LOAD(now, &samples[k]);
        step(&controller, &now, commands);
        put(commands, sizeof commands);
    }
    put(taken, sizeof taken);
    board_end(1);
    return 0;
}
