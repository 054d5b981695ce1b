/* Starts a Cortex-M4, and talks to QEMU (semihosting). */
#include <string.h>

#include "board.h"

enum { OPEN = 1, WRITE = 5, EXIT = 24 };
enum { FAILED = 0x20023, FINISHED = 0x20026 };

#define ACCESS (*(volatile uint32_t *)0xE000ED88) /* CPACR, who may use coprocessors */
#define TIMER ((volatile uint32_t *)0x40000000)   /* control, value, reload of CMSDK timer 0 */

extern uint8_t data_start[], data_end[], data_load[], bss_start[], stack_top[];
int main(void);

static int host(int operation, uintptr_t argument)
{
    register int r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_begin(void)
{
    TIMER[2] = UINT32_MAX;
    TIMER[1] = UINT32_MAX;
    TIMER[0] = 1;
}

ticks board_ticks(void)
{
    return ~TIMER[1]; /* it counts down */
}

void put(const void *data, uint16_t size)
{
    static const char console[] = ":tt";
    static int file = -1;
    if (file < 0) {
        const uintptr_t output[3] = { (uintptr_t)console, 5 /* to be written, binary */, 3 };
        file = host(OPEN, (uintptr_t)output);
    }
    const uintptr_t what[3] = { (uintptr_t)file, (uintptr_t)data, size };
    if (host(WRITE, (uintptr_t)what) != 0) {
        board_end(0);
    }
}

void board_end(int finished)
{
    host(EXIT, finished ? FINISHED : FAILED);
}

static void fault(void)
{
    board_end(0);
}

void reset(void);
void reset(void)
{
    ACCESS |= 0xFu << 20; /* all may use the floating-point unit */
    __asm__ volatile("dsb\n isb" ::: "memory");
    memcpy(data_start, data_load, (size_t)(data_end - data_start));
    memset(bss_start, 0, (size_t)(bss_end - bss_start));
    main();
}

/* Where its stack begins, where it starts, and what it does at a fault of any kind. */
__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    (uintptr_t)stack_top, (uintptr_t)reset, (uintptr_t)fault, (uintptr_t)fault,
    (uintptr_t)fault, (uintptr_t)fault, (uintptr_t)fault,
};
