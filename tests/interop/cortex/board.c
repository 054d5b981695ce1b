/* Starts a Cortex-M4, and talks to the emulator (semihosting). */
#include "board.h"

enum { OPEN = 1, WRITE = 5, EXIT = 24 };
enum { FAILED = 0x20023, FINISHED = 0x20026 };

#define ACCESS (*(volatile uint32_t *)0xE000ED88) /* CPACR, who may use coprocessors */
#define TIMER ((volatile uint32_t *)0x40000000)   /* control, value, reload of CMSDK timer 0 */

extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[], stack_top[];
int main(void);

static int host(int operation, uintptr_t argument)
{
    register int r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

uint32_t ticks(void)
{
    return ~TIMER[1]; /* it counts down */
}

void put(const void *data, uint32_t size)
{
    static const char console[] = ":tt";
    const uintptr_t output[3] = { (uintptr_t)console, 5 /* to be written, binary */, 3 };
    const int file = host(OPEN, (uintptr_t)output);
    const uintptr_t what[3] = { (uintptr_t)file, (uintptr_t)data, size };
    if (host(WRITE, (uintptr_t)what) != 0) {
        host(EXIT, FAILED);
    }
}

static void fault(void)
{
    host(EXIT, FAILED);
}

void reset(void);
void reset(void)
{
    ACCESS |= 0xFu << 20; /* all may use the floating-point unit */
    __asm__ volatile("dsb\n isb" ::: "memory");
    for (uint32_t k = 0; data_start + k < data_end; k++) {
        data_start[k] = data_load[k];
    }
    for (uint32_t *word = bss_start; word < bss_end; word++) {
        *word = 0;
    }
    TIMER[2] = UINT32_MAX;
    TIMER[1] = UINT32_MAX;
    TIMER[0] = 1;
    host(EXIT, main() == 0 ? FINISHED : FAILED);
}

/* Where its stack begins, where it starts, and what it does at a fault of any kind. */
__attribute__((section(".vectors"), used)) static const uintptr_t vectors[] = {
    (uintptr_t)stack_top, (uintptr_t)reset, (uintptr_t)fault, (uintptr_t)fault,
    (uintptr_t)fault, (uintptr_t)fault, (uintptr_t)fault,
};
