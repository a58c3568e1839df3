/* photon/pages.h: arrays that grow in place: address space is reserved at once, memory comes page by page where it is
 * written. Nothing is copied as they grow, several threads may fill parts of their own, and what is not used costs
 * nothing. */
#ifndef CPM_PHOTON_PAGES_H
#define CPM_PHOTON_PAGES_H
#include <stddef.h>

/* Room for *bytes and a page more, zero where it is not written; NULL where there is none. Where the system grants less
 * (a limit on address space), *bytes tells how much. */
void *cpm_pages_reserve(size_t *bytes);
/* About to be written, all of it: faster than a page at a time. A hint. */
void cpm_pages_expect(void *from, size_t bytes);
/* Gives back all but the first `bytes`. */
void cpm_pages_trim(void *pages, size_t bytes);
void cpm_pages_free(void *pages); /* NULL is allowed */
#endif
