/* io/atomic_file.h: write beside, then rename: what stands at a path is the old file or the whole new one. Internal. */
#ifndef CPM_IO_ATOMIC_FILE_H
#define CPM_IO_ATOMIC_FILE_H
#include <stdint.h>

typedef struct cpm_atomic_file {
    int descriptor;
    int error;        /* the first errno met while writing, 0: none */
    const char *path; /* the caller's; must outlive the file */
    char *temporary;
} cpm_atomic_file;

/* Makes the temporary file in the directory of `path`. Returns 0, or an errno. EEXIST: `path` names something that is
 * not a regular file (a device, a directory), which a rename would destroy or trip over. */
int cpm_atomic_file_open(cpm_atomic_file *file, const char *path);

/* Writes `size` bytes at `offset`. Returns 0, or an errno, which is also kept in file->error. */
int cpm_atomic_file_write(cpm_atomic_file *file, const void *bytes, uint64_t size, uint64_t offset);

/* Flushes and renames. Returns 0, or an errno (then nothing is left behind and `path` is what it was). Either this or
 * _abandon ends a file that was opened. */
int cpm_atomic_file_commit(cpm_atomic_file *file);
void cpm_atomic_file_abandon(cpm_atomic_file *file);
#endif
