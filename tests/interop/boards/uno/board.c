/* An ATmega328P, which tells simavr lines of hexadecimal digits between : and ;. */
#include <avr/interrupt.h>
#include <avr/sleep.h>

#include "board.h"

void board_begin(void)
{
    TCCR1B = _BV(CS11) | _BV(CS10); /* a tick every 64 cycles */
    UCSR0A = _BV(U2X0);
    UCSR0B = _BV(TXEN0);
}

ticks board_ticks(void)
{
    return TCNT1;
}

static void put_character(char character)
{
    loop_until_bit_is_set(UCSR0A, UDRE0);
    UDR0 = (uint8_t)character;
}

void put(const void *data, uint16_t size)
{
    const uint8_t *bytes = data;
    put_character(':');
    for (uint16_t k = 0; k < size; k++) {
        put_character("0123456789abcdef"[bytes[k] >> 4]);
        put_character("0123456789abcdef"[bytes[k] & 15]);
    }
    put_character(';');
    put_character('\n');
}

void board_end(int finished)
{
    (void)finished; /* who reads the lines counts them */
    cli();
    sleep_mode();
}
