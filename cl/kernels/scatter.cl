/* kernels/scatter.cl: what happens to paths at surfaces; each work-item takes CPM_WIDTH of them. Vectors are count x 3;
 * buffers of inputs hold a whole number of CPM_WIDTH. */
#include "shared/scatter.h"
#include "shared/store.h"

real3 read3(__global const double *from);
real3 read3(__global const double *from) {
    double column[3][CPM_WIDTH];
    for (int i = 0; i < CPM_WIDTH; i++)
        for (int k = 0; k < 3; k++) column[k][i] = from[3 * (get_global_id(0) * CPM_WIDTH + i) + k];
    return triple(load_doubles(column[0], 0), load_doubles(column[1], 0), load_doubles(column[2], 0));
}

real read1(__global const double *from);
real read1(__global const double *from) {
    double value[CPM_WIDTH];
    for (int i = 0; i < CPM_WIDTH; i++) value[i] = from[get_global_id(0) * CPM_WIDTH + i];
    return load_doubles(value, 0);
}

word read_word(__global const uint *from);
word read_word(__global const uint *from) {
    uint value[CPM_WIDTH];
    for (int i = 0; i < CPM_WIDTH; i++) value[i] = from[get_global_id(0) * CPM_WIDTH + i];
    return load_words(value, 0);
}

void write3(real3 v, __global double *to);
void write3(real3 v, __global double *to) {
    double column[3][CPM_WIDTH];
    store_doubles(v.x, column[0], 0), store_doubles(v.y, column[1], 0), store_doubles(v.z, column[2], 0);
    for (int i = 0; i < CPM_WIDTH; i++)
        for (int k = 0; k < 3; k++) to[3 * (get_global_id(0) * CPM_WIDTH + i) + k] = column[k][i];
}

void write1(real v, __global double *to);
void write1(real v, __global double *to) {
    double value[CPM_WIDTH];
    store_doubles(v, value, 0);
    for (int i = 0; i < CPM_WIDTH; i++) to[get_global_id(0) * CPM_WIDTH + i] = value[i];
}

void write_word(word w, __global uint *to);
void write_word(word w, __global uint *to) {
    uint value[CPM_WIDTH];
    store_words(w, value, 0);
    for (int i = 0; i < CPM_WIDTH; i++) to[get_global_id(0) * CPM_WIDTH + i] = value[i];
}

/* Diffuse or black. `factor`: 1/length^2 of the geometric normals. Out: where a survivor would go and start, the
 * roulette's number, and codes of the direction of arrival and of the normal on that side. */
__kernel void cpm_scatter_diffuse(ulong seed, double scale, __global const double *came, __global const double *start,
                                  __global const double *hit, __global const double *normal,
                                  __global const double *factor, __global const uint *path, __global const uint *block,
                                  __global const uint *bin, __global double *toward, __global double *from,
                                  __global double *chance, __global uint *direction_code, __global uint *normal_code) {
    real3 way = read3(came), facing = scatter_facing(scale3(root(read1(factor)), read3(normal)), way);
    word random[4];
    philox_lanes(seed, read_word(path), read_word(block), CPM_STREAM_SCATTER, read_word(bin), random);
    write3(scatter_diffuse(facing, random), toward);
    write3(scatter_step_back(read3(hit), read3(start), way, scale), from);
    write1(uniform_lanes(random[2]), chance);
    write_word(octahedral_encode(way), direction_code);
    write_word(octahedral_encode(facing), normal_code);
}

/* Mirrors; normals are unit. */
__kernel void cpm_scatter_mirror(__global const double *came, __global const double *shading,
                                 __global const double *geometric, __global double *toward) {
    real3 way = read3(came);
    write3(scatter_mirror(way, read3(shading), scatter_facing(read3(geometric), way)), toward);
}

/* Jumps of n; normals are unit. */
__kernel void cpm_scatter_boundary(__global const double *came, __global const double *shading,
                                   __global const double *geometric, __global const double *n1,
                                   __global const double *n2, __global double *reflectance, __global double *reflected,
                                   __global double *refracted) {
    real3 back, on;
    write1(scatter_boundary(read3(came), read3(shading), read3(geometric), read1(n1), read1(n2), &back, &on),
           reflectance);
    write3(back, reflected);
    write3(on, refracted);
}

/* Roulette over one bin a work-item: power after it, what the surface reflects, what roulette changes. */
__kernel void cpm_scatter_roulette(__global const float *power, __global const float *reflectance,
                                   __global const float *share, __global const int *alive, __global float *after,
                                   __global double *kept, __global double *change) {
    size_t i = get_global_id(0);
    double k, c;
    after[i] = cpm_roulette(power[i], reflectance[i], share[i], alive[i], &k, &c);
    kept[i] = k, change[i] = c;
}

/* One photon a work-item: its record, and its powers (count x bins) as 16-bit floats. `at`: count x 3. */
__kernel void cpm_scatter_store(__global const double *at, __global const uint *direction_code,
                                __global const uint *normal_code, __global const uint *path,
                                __global const uint *bounce, __global const int *bin, __global const float *powers,
                                uint bins, __global cpm_photon *photons, __global ushort *spectra) {
    size_t i = get_global_id(0);
    cpm_vec place;
    place.x = at[3 * i], place.y = at[3 * i + 1], place.z = at[3 * i + 2];
    cpm_photon_pack(&photons[i], place, direction_code[i], normal_code[i], (uint)i * bins, path[i], bounce[i], bin[i]);
    uint state = cpm_dither_start(path[i], bounce[i], bin[i] < 0 ? CPM_ALL_BINS : (uint)bin[i]);
    for (uint b = 0; b < bins; b++) {
        state = cpm_dither_next(state);
        spectra[i * bins + b] = cpm_half_dithered(powers[i * bins + b], state);
    }
}
