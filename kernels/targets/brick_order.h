// One definition for the host and the kernels: how bricks are counted on their way into the order of the lattice.
#ifndef CLSDF_BRICK_ORDER_H
#define CLSDF_BRICK_ORDER_H

// Bricks of a range, whose numbers follow one another.
#define CLSDF_RANGE_BRICKS 64

#endif
