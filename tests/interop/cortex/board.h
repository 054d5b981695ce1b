/* What the board has: a clock, and somebody who emulates it. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Ticks of 40 ns; those of two calls can be subtracted within 171 s. */
uint32_t ticks(void);

/* Write to the standard output of the emulator; it ends where that fails. */
void put(const void *data, uint32_t size);

#endif
