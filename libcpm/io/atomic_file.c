/* io/atomic_file.c: write beside, then rename. */
#include "io/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define ATTEMPTS 1000

int cpm_atomic_file_open(cpm_atomic_file *file, const char *path) {
    *file = (cpm_atomic_file){.descriptor = -1, .path = path};
    struct stat there;
    if (stat(path, &there) == 0 && !S_ISREG(there.st_mode)) return EEXIST;

    const size_t size = strlen(path) + 48;
    file->temporary = malloc(size);
    if (!file->temporary) return ENOMEM;
    /* O_EXCL and a name of our own instead of mkstemp: the mode then follows the user's umask. */
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        snprintf(file->temporary, size, "%s.%ld-%d.tmp", path, (long)getpid(), attempt);
        file->descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file->descriptor >= 0) return 0;
        if (errno != EEXIST) break;
    }
    const int error = errno;
    free(file->temporary);
    file->temporary = NULL;
    return error;
}

int cpm_atomic_file_write(cpm_atomic_file *file, const void *bytes, uint64_t size, uint64_t offset) {
    const char *from = bytes;
    while (size > 0 && !file->error) {
        const ssize_t written = pwrite(file->descriptor, from, (size_t)size, (off_t)offset);
        if (written < 0) {
            if (errno != EINTR) file->error = errno;
        } else {
            from += written;
            offset += (uint64_t)written;
            size -= (uint64_t)written;
        }
    }
    return file->error;
}

int cpm_atomic_file_commit(cpm_atomic_file *file) {
    /* Without fsync a power cut could leave the new name on an empty file. */
    if (!file->error && fsync(file->descriptor) != 0 && errno != EINVAL) file->error = errno;
    if (close(file->descriptor) != 0 && !file->error) file->error = errno;
    file->descriptor = -1;
    if (!file->error && rename(file->temporary, file->path) != 0) file->error = errno;
    const int error = file->error;
    if (error) {
        cpm_atomic_file_abandon(file);
        return error;
    }
    free(file->temporary);
    file->temporary = NULL;
    return 0;
}

void cpm_atomic_file_abandon(cpm_atomic_file *file) {
    if (file->descriptor >= 0) close(file->descriptor);
    if (file->temporary) unlink(file->temporary);
    free(file->temporary);
    file->descriptor = -1;
    file->temporary = NULL;
}
