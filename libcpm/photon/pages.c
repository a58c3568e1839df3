/* photon/pages.c: reserved address space, by mmap. One page before the array remembers how long the mapping is. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS, madvise */
#include "pages.h"

#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

#ifndef MAP_NORESERVE
#define MAP_NORESERVE 0
#endif
#define LEAST ((size_t)1 << 16)
#define SMALL ((size_t)1 << 22) /* arrays that stay below this have small pages only */

static size_t page_size(void) { return (size_t)sysconf(_SC_PAGESIZE); }

static size_t whole_pages(size_t bytes) { return (bytes + page_size() - 1) / page_size() * page_size(); }

static size_t *length_of(void *pages) { return (size_t *)(void *)((char *)pages - page_size()); }

/* Zeroing a large page costs half of zeroing its parts; but a few photons should not fill one. */
static void prefer_huge(char *memory, size_t length) {
#ifdef MADV_HUGEPAGE
    if (length > 2 * SMALL) (void)madvise(memory + SMALL, length - SMALL, MADV_HUGEPAGE);
#else
    (void)memory, (void)length;
#endif
}

void *cpm_pages_reserve(size_t *bytes) {
    for (size_t wanted = *bytes;; wanted /= 2) {
        const size_t length = 2 * page_size() + whole_pages(wanted);
        char *memory = mmap(NULL, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (memory != MAP_FAILED) {
            prefer_huge(memory, length);
            *(size_t *)(void *)memory = length;
            *bytes = wanted;
            return memory + page_size();
        }
        if (wanted <= LEAST) return NULL;
    }
}

void cpm_pages_expect(void *from, size_t bytes) {
#ifdef MADV_POPULATE_WRITE
    char *first = (char *)((uintptr_t)from / page_size() * page_size());
    (void)madvise(first, whole_pages((size_t)((char *)from + bytes - first)), MADV_POPULATE_WRITE);
#else
    (void)from, (void)bytes;
#endif
}

void cpm_pages_trim(void *pages, size_t bytes) {
    const size_t kept = page_size() + whole_pages(bytes), length = *length_of(pages);
    if (kept >= length) return;
    *length_of(pages) = kept;
    munmap((char *)pages - page_size() + kept, length - kept);
}

void cpm_pages_free(void *pages) {
    if (pages) munmap((char *)pages - page_size(), *length_of(pages));
}
