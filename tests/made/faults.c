/* Calls of the C library on files below a folder are counted, and one of them goes wrong.

   Preloaded into a process, this stands for a disk that fails, a file that vanishes, a slow
   network, and a process that is killed between two calls. Python, netCDF and HDF5 all come by. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { OPEN = 1, READ = 2, WRITE = 4, STAT = 8 };
enum { FAIL, SHORT, DELAY, KILL };

/* Shared with forks, so that the parent reads the count of a killed child. */
static struct {
    char folder[PATH_MAX];
    int kinds, what, number, at, calls, sticky, of_kind[STAT + 1];
} *plan;

/* File of the names at which processes have ended, or NULL; what a name must contain; and whether
   the process ends alone, not with all of its group. */
static const char *seams, *only, *alone;

__attribute__((constructor)) static void set_up(void)
{
    plan = mmap(NULL, sizeof *plan, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    seams = getenv("FAULTS_SEAMS");
    only = getenv("FAULTS_ONLY"), alone = getenv("FAULTS_ALONE");
    if (seams)
        strcpy(plan->folder, getenv("FAULTS_FOLDER"));
}

/* The `at`-th call of some kinds below a folder goes wrong, and all later ones where sticky. */
void faults_arm(const char *folder, int kinds, int what, int number, int at, int sticky)
{
    strcpy(plan->folder, folder);
    plan->kinds = kinds, plan->what = what, plan->number = number;
    plan->at = at, plan->sticky = sticky, plan->calls = 0;
    memset(plan->of_kind, 0, sizeof plan->of_kind);
}

/* The number of calls of a kind so far. */
int faults_calls(int kind) { return plan->of_kind[kind]; }

static int is_below(int folder, const char *path)
{
    char full[2 * PATH_MAX];
    size_t length = strlen(plan->folder);
    if (path && path[0] == '/') {
        snprintf(full, sizeof full, "%s", path);
    } else {
        char link[64];
        if (folder == AT_FDCWD)
            snprintf(link, sizeof link, "/proc/self/cwd");
        else
            snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        ssize_t size = readlink(link, full, PATH_MAX - 1);
        if (size < 0)
            return 0;
        full[size] = 0;
        if (path && path[0])
            snprintf(full + size, sizeof full - size, "/%s", path);
    }
    return !strncmp(full, plan->folder, length);
}

/* End processes once a file has or loses its name, the first time for each name below the folder.
   Names of temporary files, which are others in each run, do not count. */
static int seam(int result, int folder, const char *path)
{
    char line[2 * PATH_MAX], name[2 * PATH_MAX];
    int before = errno;
    if (result || !seams || !is_below(folder, path) || strstr(path, ".part") || strstr(path, "tmp")
        || (only && !strstr(path, only)))
        return errno = before, result;
    snprintf(name, sizeof name, "%s\n", path);
    FILE *list = fopen(seams, "a+");
    rewind(list);
    while (fgets(line, sizeof line, list))
        if (!strcmp(line, name)) {
            fclose(list);
            return errno = before, result;
        }
    fputs(name, list);
    fclose(list);
    kill(alone ? getpid() : 0, SIGKILL);
    return result;
}

/* Return whether this call fails; `errno` is then set. */
static int fails(int kind, int folder, const char *path, int *is_short)
{
    if (!plan || !plan->at || !(plan->kinds & kind))
        return 0;
    int before = errno;
    if (!is_below(folder, path)) {
        errno = before;
        return 0;
    }
    int call = __atomic_add_fetch(&plan->calls, 1, __ATOMIC_SEQ_CST);
    __atomic_add_fetch(&plan->of_kind[kind], 1, __ATOMIC_SEQ_CST);
    errno = before;
    if (call != plan->at && !(plan->sticky && call > plan->at))
        return 0;
    switch (plan->what) {
    case KILL:
        raise(SIGKILL);
        return 0;
    case DELAY:
        usleep(1000 * plan->number);
        return 0;
    case SHORT:
        if (is_short)
            *is_short = 1;
        return 0;
    }
    errno = plan->number;
    return 1;
}

#define REAL(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) \
        real = (type (*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name)

#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { \
        va_list list; \
        va_start(list, flags); \
        mode = va_arg(list, mode_t); \
        va_end(list); \
    }

#define OPENING(name) \
    int name(const char *path, int flags, ...) \
    { \
        REAL(int, name, const char *, int, ...); \
        MODE \
        return fails(OPEN, AT_FDCWD, path, NULL) ? -1 : real(path, flags, mode); \
    }
OPENING(open)
OPENING(open64)

#define OPENING_AT(name) \
    int name(int folder, const char *path, int flags, ...) \
    { \
        REAL(int, name, int, const char *, int, ...); \
        MODE \
        return fails(OPEN, folder, path, NULL) ? -1 : real(folder, path, flags, mode); \
    }
OPENING_AT(openat)
OPENING_AT(openat64)

#define STREAM(name) \
    FILE *name(const char *path, const char *mode) \
    { \
        REAL(FILE *, name, const char *, const char *); \
        return fails(OPEN, AT_FDCWD, path, NULL) ? NULL : real(path, mode); \
    }
STREAM(fopen)
STREAM(fopen64)

DIR *opendir(const char *path)
{
    REAL(DIR *, opendir, const char *);
    return fails(OPEN, AT_FDCWD, path, NULL) ? NULL : real(path);
}

#define PART size = is_short && size > 1 ? size / 2 : size;

ssize_t read(int file, void *to, size_t size)
{
    REAL(ssize_t, read, int, void *, size_t);
    int is_short = 0;
    if (fails(READ, file, NULL, &is_short))
        return -1;
    PART
    return real(file, to, size);
}

ssize_t write(int file, const void *from, size_t size)
{
    REAL(ssize_t, write, int, const void *, size_t);
    int is_short = 0;
    if (fails(WRITE, file, NULL, &is_short))
        return -1;
    PART
    return real(file, from, size);
}

#define AT_PLACE(name, kind, pointer) \
    ssize_t name(int file, pointer data, size_t size, off64_t place) \
    { \
        REAL(ssize_t, name, int, pointer, size_t, off64_t); \
        int is_short = 0; \
        if (fails(kind, file, NULL, &is_short)) \
            return -1; \
        PART \
        return real(file, data, size, place); \
    }
AT_PLACE(pread, READ, void *)
AT_PLACE(pread64, READ, void *)
AT_PLACE(pwrite, WRITE, const void *)
AT_PLACE(pwrite64, WRITE, const void *)

#define OF_FILE(name) \
    int name(int file) \
    { \
        REAL(int, name, int); \
        return fails(WRITE, file, NULL, NULL) ? -1 : real(file); \
    }
OF_FILE(fsync)
OF_FILE(fdatasync)

#define OF_LENGTH(name) \
    int name(int file, off64_t size) \
    { \
        REAL(int, name, int, off64_t); \
        return fails(WRITE, file, NULL, NULL) ? -1 : real(file, size); \
    }
OF_LENGTH(ftruncate)
OF_LENGTH(ftruncate64)

#define OF_TWO(name) \
    int name(const char *from, const char *to) \
    { \
        REAL(int, name, const char *, const char *); \
        return fails(WRITE, AT_FDCWD, to, NULL) ? -1 : seam(real(from, to), AT_FDCWD, to); \
    }
OF_TWO(rename)
OF_TWO(link)
OF_TWO(symlink)

int renameat(int one, const char *from, int other, const char *to)
{
    REAL(int, renameat, int, const char *, int, const char *);
    return fails(WRITE, other, to, NULL) ? -1 : seam(real(one, from, other, to), other, to);
}

int linkat(int one, const char *from, int other, const char *to, int flags)
{
    REAL(int, linkat, int, const char *, int, const char *, int);
    return fails(WRITE, other, to, NULL) ? -1 : seam(real(one, from, other, to, flags), other, to);
}

#define OF_PATH(name) \
    int name(const char *path) \
    { \
        REAL(int, name, const char *); \
        return fails(WRITE, AT_FDCWD, path, NULL) ? -1 : seam(real(path), AT_FDCWD, path); \
    }
OF_PATH(unlink)
OF_PATH(rmdir)

int unlinkat(int folder, const char *path, int flags)
{
    REAL(int, unlinkat, int, const char *, int);
    return fails(WRITE, folder, path, NULL) ? -1 : seam(real(folder, path, flags), folder, path);
}

int mkdir(const char *path, mode_t mode)
{
    REAL(int, mkdir, const char *, mode_t);
    return fails(WRITE, AT_FDCWD, path, NULL) ? -1 : real(path, mode);
}

int utimensat(int folder, const char *path, const struct timespec times[2], int flags)
{
    REAL(int, utimensat, int, const char *, const struct timespec *, int);
    return fails(WRITE, folder, path, NULL) ? -1 : real(folder, path, times, flags);
}

#define STATUS(name, of) \
    int name(const char *path, struct of *status) \
    { \
        REAL(int, name, const char *, struct of *); \
        return fails(STAT, AT_FDCWD, path, NULL) ? -1 : real(path, status); \
    }
STATUS(stat, stat)
STATUS(stat64, stat64)
STATUS(lstat, stat)
STATUS(lstat64, stat64)

#define STATUS_OF_FILE(name, of) \
    int name(int file, struct of *status) \
    { \
        REAL(int, name, int, struct of *); \
        return fails(STAT, file, NULL, NULL) ? -1 : real(file, status); \
    }
STATUS_OF_FILE(fstat, stat)
STATUS_OF_FILE(fstat64, stat64)

#define STATUS_AT(name, of) \
    int name(int folder, const char *path, struct of *status, int flags) \
    { \
        REAL(int, name, int, const char *, struct of *, int); \
        return fails(STAT, folder, path, NULL) ? -1 : real(folder, path, status, flags); \
    }
STATUS_AT(fstatat, stat)
STATUS_AT(fstatat64, stat64)
