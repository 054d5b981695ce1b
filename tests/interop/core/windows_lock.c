/* The calls of Windows of which core/lock.py consists, in two processes: windows_lock, in an empty folder.
 *
 * Prints the first that does not do what it expects, and returns 1; prints "as expected" otherwise.
 */
#include <fcntl.h>
#include <io.h>
#include <stdio.h>
#include <string.h>
#include <sys/locking.h>
#include <windows.h>

#define EXPECT(what)                 \
    if (!(what)) {                   \
        printf("not: %s\n", #what);  \
        TerminateProcess(process, 2); \
        return 1;                    \
    }

static int opened(const char *path, DWORD when)
{
    const HANDLE handle = CreateFileA(path, 0xC0000000, 7, NULL, when, 0x200000, NULL);
    return handle == INVALID_HANDLE_VALUE ? -1 : _open_osfhandle((intptr_t)handle, 0);
}

static int locked(int file)
{
    _lseek(file, 1 << 30, SEEK_SET);
    return _locking(file, _LK_NBLCK, 1) == 0;
}

static int renamed(const char *from, const char *to, DWORD how)
{
    return MoveFileExA(from, to, how);
}

int main(int count, char **words)
{
    HANDLE process = NULL;
    char text[8] = "";
    if (count > 1) { /* the process that holds the lock, and is frozen then */
        const int file = opened("lock", OPEN_ALWAYS);
        EXPECT(locked(file));
        EXPECT(_lseek(file, 0, SEEK_SET) == 0 && _write(file, "holder", 6) == 6);
        EXPECT(CloseHandle(CreateFileA("held", 0xC0000000, 7, NULL, CREATE_NEW, 0, NULL)));
        Sleep(INFINITE);
    }
    STARTUPINFOA start = { sizeof start };
    PROCESS_INFORMATION holder;
    char command[MAX_PATH + 8];
    snprintf(command, sizeof command, "%s hold", words[0]);
    EXPECT(CreateProcessA(NULL, command, NULL, NULL, FALSE, 0, NULL, NULL, &start, &holder));
    process = holder.hProcess;
    for (int k = 0; k < 600 && GetFileAttributesA("held") == INVALID_FILE_ATTRIBUTES; k++) {
        Sleep(100);
    }
    const int file = opened("lock", OPEN_ALWAYS), new = opened("new", CREATE_NEW);
    EXPECT(!locked(file)); /* it is refused, and can read who has the lock */
    EXPECT(_lseek(file, 0, SEEK_SET) == 0 && _read(file, text, 6) == 6 && !strcmp(text, "holder"));
    EXPECT(opened("new", CREATE_NEW) < 0 && opened("missing", OPEN_EXISTING) < 0);
    EXPECT(locked(new)); /* it overtakes: the old file is renamed and deleted, open as it is */
    EXPECT(!renamed("new", "lock", MOVEFILE_REPLACE_EXISTING));
    EXPECT(renamed("lock", "aside", 0) && DeleteFileA("aside"));
    EXPECT(renamed("new", "lock", MOVEFILE_REPLACE_EXISTING));
    EXPECT(!locked(opened("lock", OPEN_EXISTING)));
    EXPECT(!locked(file)); /* the first one has its lock until it ends */
    EXPECT(TerminateProcess(process, 1) && WaitForSingleObject(process, INFINITE) == 0);
    EXPECT(locked(file));
    puts("as expected");
    return 0;
}
