/* backend/opencl/program_disk.c: binaries of programs, a file each: magic, sizes, the whole key, the binary, a
 * checksum. */
#include "program.h"

#ifdef CPM_OPENCL_HEADERS_VERSION
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "io/atomic_file.h"
#include "source.h"

#define MAGIC UINT64_C(0x31304c434d5043) /* "CPMCL01" */
#define MOST_BYTES (UINT64_C(1) << 28)

typedef struct header {
    uint64_t magic, key_size, binary_size, checksum;
} header;

static uint64_t checksum_of(const char *key, const void *binary, size_t size) {
    return cpm_hash(cpm_hash(CPM_HASH_START, key, strlen(key)), binary, size);
}

/* Makes the folder where `make` is set; 0: there is to be no cache. */
static int path_of(const char *key, char *path, size_t size, int make) {
    const char *own = getenv("CPM_CACHE_DIR"), *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    char folder[768];
    int length;
    if (own)
        length = snprintf(folder, sizeof folder, "%s", own);
    else if (cache && *cache)
        length = snprintf(folder, sizeof folder, "%s/cpm", cache);
    else if (home && *home)
        length = snprintf(folder, sizeof folder, "%s/.cache/cpm", home);
    else
        return 0;
    if (length <= 0 || (size_t)length >= sizeof folder) return 0;
    if (make)
        for (char *slash = strchr(folder + 1, '/');; slash = strchr(slash + 1, '/')) {
            if (slash) *slash = '\0';
            if (mkdir(folder, 0777) && errno != EEXIST) return 0;
            if (!slash) break;
            *slash = '/';
        }
    length =
        snprintf(path, size, "%s/%016llx.bin", folder, (unsigned long long)cpm_hash(CPM_HASH_START, key, strlen(key)));
    return length > 0 && (size_t)length < size;
}

void *cpm_program_load(const char *key, size_t *size) {
    char path[1024], *kept = NULL;
    unsigned char *binary = NULL;
    header h;
    if (!path_of(key, path, sizeof path, 0)) return NULL;
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    int good = fread(&h, sizeof h, 1, file) == 1 && h.magic == MAGIC && h.key_size == strlen(key) && h.binary_size &&
               h.binary_size <= MOST_BYTES;
    if (good) {
        kept = calloc(1, (size_t)h.key_size + 1);
        binary = malloc((size_t)h.binary_size);
        good = kept && binary && fread(kept, 1, (size_t)h.key_size, file) == h.key_size && !strcmp(kept, key) &&
               fread(binary, 1, (size_t)h.binary_size, file) == h.binary_size && fgetc(file) == EOF &&
               h.checksum == checksum_of(key, binary, (size_t)h.binary_size);
    }
    fclose(file);
    free(kept);
    if (!good) {
        free(binary);
        return NULL;
    }
    *size = (size_t)h.binary_size;
    return binary;
}

/* A cache that cannot be written is no error: the next run compiles again. */
void cpm_program_save(const char *key, const void *binary, size_t size) {
    char path[1024];
    cpm_atomic_file file;
    if (size > MOST_BYTES || !path_of(key, path, sizeof path, 1) || cpm_atomic_file_open(&file, path)) return;
    const header h = {MAGIC, strlen(key), size, checksum_of(key, binary, size)};
    cpm_atomic_file_write(&file, &h, sizeof h, 0);
    cpm_atomic_file_write(&file, key, h.key_size, sizeof h);
    cpm_atomic_file_write(&file, binary, size, sizeof h + h.key_size);
    cpm_atomic_file_commit(&file);
}
#endif
