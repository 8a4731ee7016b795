// Structs of the frames of LANES faces at once, one a lane: the frame is that of polyhedron.h, in double. The host has
// them with one lane (lib/engine/frusta/frames.hpp).
#ifndef CLSDF_LANE_FRAMES_H
#define CLSDF_LANE_FRAMES_H

// A vector a lane.
typedef struct Vectors {
    doubleL x, y, z;
} Vectors;

typedef struct BaseEdges {
    longL is_first, is_second;  // which edge of the face is the base; else the third
} BaseEdges;

typedef struct FaceFrames {
    BaseEdges base_edges;
    Vectors start, end, apex;  // positions, from the start of the base
    Vectors base, to_apex;     // edges, in units
    Vectors along, across, normal;
    doubleL length, height;
    doubleL right, left;  // the halves' bases
    doubleL along_right, along_left, across_right, across_left;
    doubleL altitude;
    Vectors foot;
} FaceFrames;

#endif
