// Positions of the numbers of a polyhedron (polyhedron.h): in its words and, up to the normals, in its exact
// numbers.
#ifndef CLSDF_RECORD_NUMBERS_H
#define CLSDF_RECORD_NUMBERS_H

#define NUMBER_GRADIENT_X 0
#define NUMBER_GRADIENT_Y 3
#define NUMBER_GRADIENT_Z 6
#define NUMBER_CONSTANT 9
#define NUMBER_BASE 12
#define NUMBER_NORMAL_ALONG 14
#define NUMBER_NORMAL_ACROSS 16

#define WORD_SLOPE_ABOVE 18
#define WORD_SLOPE_BELOW 21
#define WORD_FOOT 24
#define WORD_ORIGIN 27
#define WORD_FLAGS 30
#define WORDS 32

#define EXACT_ALTITUDE 18
#define EXACT_NUMBERS 19

// The frame's n-th coordinate (i, j, k) samples from the integer origin.
#define FRAME_AT(numbers, n, i, j, k)       \
    ((numbers)[NUMBER_GRADIENT_X + n] * i + \
     ((numbers)[NUMBER_GRADIENT_Y + n] * j + ((numbers)[NUMBER_GRADIENT_Z + n] * k + (numbers)[NUMBER_CONSTANT + n])))

#endif
