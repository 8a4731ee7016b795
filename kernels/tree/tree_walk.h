// The walks down the trees of a mesh's faces. The host compiles them, too.
//
// Both trees have one walk each, and a query is the functions that a walk is defined with: which boxes it enters,
// and what it does at a leaf. Each function gets the query's own struct, in which it keeps what it finds.
//
// The definitions have no storage class: write INLINE, OUT_OF_LINE or a template's head before them.
#ifndef CLSDF_TREE_WALK_H
#define CLSDF_TREE_WALK_H

#include "binary_tree.h"
#include "point_tree.h"

// Defines walk(), which goes down the wide tree (point_tree.h) until a leaf ends it, and returns whether one did.
// nodes: from level 2 on.
//
//     uint choose(__global const PointNode* node, uint level, __private Query* query)
//         Bits of the children that may be visited, of a node of level 2 or above. Those of children that do not exist
//         have no effect.
//     uint next_of(uint bits, uint level, __private Query* query)
//         The child to visit next of those that are left, of the present node of this level; or CLSDF_NO_CHILD.
//     bool visit_leaf(uint leaf, __private Query* query)
//         Visits a node of level 1. True ends the walk.
#define DEFINE_WIDE_WALK(walk, Query, choose, next_of, visit_leaf)                                              \
    bool walk(PointTree tree, __global const PointNode* nodes, __private Query* query) {                        \
        if (tree.levels == 1) return visit_leaf(0, query);                                                      \
        uint numbers[CLSDF_TREE_LEVELS + 1], waiting[CLSDF_TREE_LEVELS + 1];                                    \
        for (uint level = tree.levels, number = 0;; --level) {                                                  \
            const uint chosen = choose(nodes + (tree.first[level - 1] - tree.count[0]) + number, level, query); \
            const uint children = tree.count[level - 2] - number * CLSDF_TREE_WIDTH;                            \
            numbers[level] = number;                                                                            \
            waiting[level] = children < CLSDF_TREE_WIDTH ? chosen & ((1u << children) - 1u) : chosen;           \
            for (;;) {                                                                                          \
                while (waiting[level] == 0)                                                                     \
                    if (++level > tree.levels) return false;                                                    \
                const uint child = next_of(waiting[level], level, query);                                       \
                if (child == CLSDF_NO_CHILD) {                                                                  \
                    waiting[level] = 0;                                                                         \
                    continue;                                                                                   \
                }                                                                                               \
                waiting[level] &= ~(1u << child);                                                               \
                number = numbers[level] * CLSDF_TREE_WIDTH + child;                                             \
                if (level > 2) break;                                                                           \
                if (visit_leaf(number, query)) return true;                                                     \
            }                                                                                                   \
        }                                                                                                       \
    }

// Four words of a struct, in one load.
#define FOUR_WORDS(at, number) (((__global const uint4*)(at))[number])

// The lower and the upper planes of a node's word, in units.
#define LOWER_OF(word) ((float)((word)&0xFFFFu) * CLSDF_BOX_CELL)
#define UPPER_OF(word) ((float)((word) >> 16) * CLSDF_BOX_CELL)

// Defines walk(), which goes down the binary tree (binary_tree.h) until a leaf ends it, and returns whether one did.
// The nearer child comes first; the other one waits on the stack with its distance, rounded down. stack: memory of the
// address space `space`, an entry in each `stride` words, as many entries as the tree is deep.
//
//     float distance_to(float lower_x, ..., float upper_z, __private Query* query)
//         A measure of a box that is not negative: any distance, or its square, or 0 and INFINITY for yes and no.
//     float bound_of(__private Query* query)
//         Boxes with a greater measure are left out.
//     bool visit_leaf(uint place, __private Query* query)
//         Visits the faces of a leaf, whose first place this is. True ends the walk.
#define DEFINE_BINARY_WALK(walk, Query, space, distance_to, bound_of, visit_leaf)                                    \
    bool walk(BinaryTree tree, __global const BinaryNode* nodes, space uint* stack, uint stride,                     \
              __private Query* query) {                                                                              \
        uint link = tree.root, height = 0;                                                                           \
        for (;;) {                                                                                                   \
            bool goes_on = false;                                                                                    \
            if (link & tree.leaf) {                                                                                  \
                if (visit_leaf(link & ~tree.leaf, query)) return true;                                               \
            } else {                                                                                                 \
                COUNTED(boxes, 2);                                                                                   \
                __global const BinaryNode* node = nodes + link;                                                      \
                const uint4 a = FOUR_WORDS(node, 0), b = FOUR_WORDS(node, 1);                                        \
                const float first = distance_to(LOWER_OF(a.x), LOWER_OF(a.y), LOWER_OF(a.z), UPPER_OF(a.x),          \
                                                UPPER_OF(a.y), UPPER_OF(a.z), query),                                \
                            second = distance_to(LOWER_OF(a.w), LOWER_OF(b.x), LOWER_OF(b.y), UPPER_OF(a.w),         \
                                                 UPPER_OF(b.x), UPPER_OF(b.y), query);                               \
                const bool is_first = first <= second;                                                               \
                const float nearer = is_first ? first : second, farther = is_first ? second : first;                 \
                if (nearer <= bound_of(query)) {                                                                     \
                    goes_on = true;                                                                                  \
                    link = is_first ? b.z : b.w;                                                                     \
                    if (farther <= bound_of(query))                                                                  \
                        stack[height++ * stride] = (is_first ? b.w : b.z) | (as_uint(farther) << 1 & tree.distance); \
                }                                                                                                    \
            }                                                                                                        \
            while (!goes_on) {                                                                                       \
                if (height == 0) return false;                                                                       \
                link = stack[--height * stride];                                                                     \
                goes_on = as_float((link & tree.distance) >> 1) <= bound_of(query);                                  \
            }                                                                                                        \
            link &= ~tree.distance;                                                                                  \
        }                                                                                                            \
    }

#endif
