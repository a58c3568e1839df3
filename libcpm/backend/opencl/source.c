/* backend/opencl/source.c: one text of a kernel and all that it includes. */
#include "source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILES 256

typedef struct text {
    char *bytes;
    size_t size, capacity;
    int failed;
    unsigned char seen[MAX_FILES];
} text;

uint64_t cpm_hash(uint64_t hash, const void *bytes, size_t size) {
    const unsigned char *from = bytes;
    for (size_t i = 0; i < size; i++) hash = (hash ^ from[i]) * UINT64_C(1099511628211);
    return hash;
}

static void append(text *t, const char *bytes, size_t size) {
    if (t->size + size + 1 > t->capacity) {
        size_t capacity = 2 * (t->size + size + 1);
        char *more = realloc(t->bytes, capacity);
        if (!more) {
            t->failed = 1;
            return;
        }
        t->bytes = more, t->capacity = capacity;
    }
    memcpy(t->bytes + t->size, bytes, size);
    t->size += size;
    t->bytes[t->size] = '\0';
}

static size_t find(const char *name, size_t size) {
    for (size_t i = 0; i < cpm_kernel_file_count; i++)
        if (strlen(cpm_kernel_files[i].name) == size && !memcmp(cpm_kernel_files[i].name, name, size)) return i;
    return SIZE_MAX;
}

/* What #include "path" means in `from`: beside it, else from the root. SIZE_MAX: a header that is not ours. */
static size_t included(const char *from, const char *path, size_t size) {
    char name[256];
    const char *slash = strrchr(from, '/');
    size_t folder = slash ? (size_t)(slash - from) : 0;
    const char *rest = path;
    size_t left = size;
    while (left > 3 && !memcmp(rest, "../", 3)) { /* one folder up */
        while (folder && from[folder - 1] != '/') folder--;
        if (folder) folder--;
        rest += 3, left -= 3;
    }
    int length = folder ? snprintf(name, sizeof name, "%.*s/%.*s", (int)folder, from, (int)left, rest)
                        : snprintf(name, sizeof name, "%.*s", (int)left, rest);
    size_t at = length > 0 && (size_t)length < sizeof name ? find(name, (size_t)length) : SIZE_MAX;
    return at != SIZE_MAX ? at : find(path, size);
}

/* The quoted path of an #include line, or NULL. */
static const char *include_of(const char *line, const char *end, size_t *size) {
    while (line < end && (*line == ' ' || *line == '\t')) line++;
    if (line == end || *line++ != '#') return NULL;
    while (line < end && (*line == ' ' || *line == '\t')) line++;
    if (end - line < 9 || memcmp(line, "include", 7)) return NULL;
    line += 7;
    while (line < end && (*line == ' ' || *line == '\t')) line++;
    if (line == end || *line++ != '"') return NULL;
    const char *quote = memchr(line, '"', (size_t)(end - line));
    if (!quote) return NULL;
    *size = (size_t)(quote - line);
    return line;
}

/* A file that drops its second reading itself; without a guard (elementary_body.h) it may be wanted again. */
static int has_guard(const cpm_kernel_file *file) { return strstr(file->text, "#ifndef CPM_") != NULL; }

static void expand(text *t, size_t which, int depth) {
    const cpm_kernel_file *file = &cpm_kernel_files[which];
    if (which >= MAX_FILES || depth > 64) {
        t->failed = 1;
        return;
    }
    if (has_guard(file)) t->seen[which] = 1;
    const char *end = file->text + file->size;
    for (const char *line = file->text; line < end && !t->failed;) {
        const char *stop = memchr(line, '\n', (size_t)(end - line));
        stop = stop ? stop + 1 : end;
        size_t size, at;
        const char *path = include_of(line, stop, &size);
        if (!path || (at = included(file->name, path, size)) == SIZE_MAX)
            append(t, line, (size_t)(stop - line));
        else if (at < MAX_FILES && !t->seen[at])
            expand(t, at, depth + 1);
        line = stop;
    }
}

char *cpm_kernel_source(const char *name, size_t *size) {
    char path[256];
    text t = {0};
    int length = snprintf(path, sizeof path, "kernels/%s.cl", name);
    size_t at = length > 0 && (size_t)length < sizeof path ? find(path, (size_t)length) : SIZE_MAX;
    if (at == SIZE_MAX) return NULL;
    expand(&t, at, 0);
    if (t.failed) {
        free(t.bytes);
        return NULL;
    }
    *size = t.size;
    return t.bytes;
}
