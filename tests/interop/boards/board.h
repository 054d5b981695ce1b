/* What a board has: memory, a clock, and somebody who emulates it. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#ifdef __AVR__
#include <avr/io.h>
#include <avr/pgmspace.h>

extern uint8_t __heap_start[];

typedef uint16_t ticks; /* of 64 cycles */
#define IN_FLASH ".progmem.samples"
#define STACK ((uint8_t *)SP + 1)
#define FREE __heap_start
#define LOAD(to, from) memcpy_P(&(to), (from), sizeof (to))
#else
extern uint8_t bss_end[];

typedef uint32_t ticks; /* of 40 ns */
#define IN_FLASH ".rodata.samples"
#define STACK \
    __extension__({ uint8_t *sp_; __asm__ volatile("mov %0, sp" : "=r"(sp_)); sp_; })
#define FREE bss_end
#define LOAD(to, from) ((to) = *(from))
#endif

void board_begin(void);
ticks board_ticks(void);

/* Tell the emulator. */
void put(const void *data, uint16_t size);

/* The emulator stops; where the program did not finish, it tells so if it can. */
void board_end(int finished);

#endif
