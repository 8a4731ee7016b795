// The first point of the surface {distance = level} on a ray, with what its shading needs.
//
// The field between samples is their trilinear interpolant F, in the block of samples; the solid is {F < level} within
// the block, without what cuts take away. Along an axis a, F changes by a mean of differences between samples that are
// neighbours along a, hence by no more than slope[a], the largest of these, which the host measures: about 1 for true
// distances (the distance is 1-Lipschitz, and so is its clamping to a band), whatever else for other fields. Along a
// unit vector d, F changes by no more than
//     rate = |d[0]| slope[0] + |d[1]| slope[1] + |d[2]| slope[2]      (<= sqrt(3) for true distances)
// so a step of (F - level) / rate passes no point of the surface: the interpolant's, exactly, in whatever cells are in
// between. Steps are at least LEAST_STEP, so that a ray that grazes the surface comes to an end; what is passed
// over is thinner than that. If the sign changes, the root is bisected.

#include "render.h"

#pragma OPENCL FP_CONTRACT OFF

#define LEAST_STEP 0.02f  // voxels
#define BISECTIONS 14     // of an interval of about LEAST_STEP: 1e-6 voxel
#define OCCLUSION_TAPS 5
#define SHADOW_STEPS 48
#define SHADOW_SHARPNESS 12.0f

static inline float3 triple(const float* v) {
    return (float3)(v[0], v[1], v[2]);
}

static inline double3 triple_of_doubles(const double* v) {
    return (double3)(v[0], v[1], v[2]);
}

static inline float value_at(const RenderView* view, __global const float* samples, float3 p) {
    const int i = clamp((int)p.x, 0, view->size[0] - 2);
    const int j = clamp((int)p.y, 0, view->size[1] - 2);
    const int k = clamp((int)p.z, 0, view->size[2] - 2);
    const float x = clamp(p.x - i, 0.0f, 1.0f), y = clamp(p.y - j, 0.0f, 1.0f), z = clamp(p.z - k, 0.0f, 1.0f);
    const size_t row = view->size[0], slice = row * view->size[1];
    __global const float* at = samples + (k * slice + j * row + i);
    // Two products each, not a + x (b - a): exact at both ends, so that neighbouring cells agree on their face.
    const float a = at[0] * (1 - x) + at[1] * x;
    const float b = at[row] * (1 - x) + at[row + 1] * x;
    const float c = at[slice] * (1 - x) + at[slice + 1] * x;
    const float d = at[slice + row] * (1 - x) + at[slice + row + 1] * x;
    return (a * (1 - y) + b * y) * (1 - z) + (c * (1 - y) + d * y) * z;
}

// Central differences; at the block's border one-sided ones.
static inline float3 gradient_at(const RenderView* view, __global const float* samples, float3 p) {
    float3 gradient;
    for (int axis = 0; axis < 3; ++axis) {
        float3 below = p, above = p;
        const float centre = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
        const float low = max(centre - view->gradient_step, 0.0f);
        const float high = min(centre + view->gradient_step, view->size[axis] - 1.0f);
        if (axis == 0) {
            below.x = low;
            above.x = high;
        } else if (axis == 1) {
            below.y = low;
            above.y = high;
        } else {
            below.z = low;
            above.z = high;
        }
        const float slope =
            (value_at(view, samples, above) - value_at(view, samples, below)) / ((high - low) * view->spacing[axis]);
        if (axis == 0) gradient.x = slope;
        if (axis == 1) gradient.y = slope;
        if (axis == 2) gradient.z = slope;
    }
    return gradient;
}

static inline bool is_cut_away(const RenderView* view, float3 p) {
    const float at[3] = {p.x, p.y, p.z};
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
        if (view->cut_side[axis] == 0) continue;
        if (view->cut_side[axis] * (at[axis] - (float)view->cut[axis]) <= 0) return false;
        any = true;
    }
    return any;
}

static inline bool is_in_block(const RenderView* view, float3 p) {
    return p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= view->size[0] - 1 && p.y <= view->size[1] - 1 &&
           p.z <= view->size[2] - 1;
}

// A part of a ray that is in the block and not cut away, and what its beginning is.
typedef struct Interval {
    double begin, end;
    int kind;
} Interval;

// The ray in the block; `kind` is of the face that it comes in by.
static inline Interval in_block(const RenderView* view, const double* origin, const double* direction) {
    Interval interval = {0, DBL_MAX, CLSDF_RENDER_BORDER};
    for (int axis = 0; axis < 3; ++axis) {
        const double last = view->size[axis] - 1;
        if (direction[axis] == 0) {
            if (origin[axis] < 0 || origin[axis] > last) interval.end = -1;
            continue;
        }
        const double one = -origin[axis] / direction[axis], other = (last - origin[axis]) / direction[axis];
        const double first = one < other ? one : other, second = one < other ? other : one;
        if (first > interval.begin) {
            interval.begin = first;
            interval.kind = CLSDF_RENDER_BORDER + axis;
        }
        if (second < interval.end) interval.end = second;
    }
    return interval;
}

// The ray in what is cut away, which is convex; `kind` is of the face that it goes out by. Empty: end < begin.
static inline Interval in_cut(const RenderView* view, const double* origin, const double* direction) {
    Interval interval = {-DBL_MAX, DBL_MAX, CLSDF_RENDER_CUT};
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
        const int side = view->cut_side[axis];
        if (side == 0) continue;
        any = true;
        const double depth = side * (view->cut[axis] - origin[axis]), speed = side * direction[axis];
        if (speed == 0) {
            if (depth >= 0) interval.end = -DBL_MAX;
        } else if (speed > 0) {
            interval.begin = fmax(interval.begin, depth / speed);
        } else if (depth / speed < interval.end) {
            interval.end = depth / speed;
            interval.kind = CLSDF_RENDER_CUT + axis;
        }
    }
    if (!any || interval.end < interval.begin) interval.end = -DBL_MAX;
    return interval;
}

// True if the ray meets the solid between begin and end; then sets the point and the kind of the hit.
static inline bool march(const RenderView* view, __global const float* samples, double3 origin, double3 direction,
                         float rate, Interval interval, RenderHit* hit, float3* point) {
    if (interval.end <= interval.begin) return false;
    const double3 from = origin + interval.begin * direction;
    const float3 start = convert_float3(from), way = convert_float3(direction);
    const float length_of_way = (float)(interval.end - interval.begin);
    float t = 0, value = value_at(view, samples, start) - view->level;
    if (value < 0) {
        *point = start;
        hit->kind = interval.kind;
        return true;
    }
    for (;;) {
        if (!(t < length_of_way)) return false;  // a length that is not a number, too
        const float before = t;
        const float step = value / rate;
        // A step that is too small for the sum to change still is one.
        t = fmin(before + (step > LEAST_STEP ? step : LEAST_STEP), length_of_way);
        value = value_at(view, samples, start + t * way) - view->level;
        if (value < 0) {
            float outside = before, inside = t;
            for (int i = 0; i < BISECTIONS; ++i) {
                const float middle = 0.5f * (outside + inside);
                if (value_at(view, samples, start + middle * way) < view->level)
                    inside = middle;
                else
                    outside = middle;
            }
            *point = start + 0.5f * (outside + inside) * way;
            hit->kind = CLSDF_RENDER_SURFACE;
            return true;
        }
    }
}

// A right-handed frame around a unit vector.
static inline void frame_around(float3 normal, float3* u, float3* v) {
    const float3 other = fabs(normal.x) < 0.6f ? (float3)(1, 0, 0) : (float3)(0, 1, 0);
    *u = normalize(cross(other, normal));
    *v = cross(normal, *u);
}

// How open the direction is, 0 ... 1: over an open plane the distance grows by the way times the cosine.
static inline float openness(const RenderView* view, __global const float* samples, float3 p, float3 direction,
                             float cosine) {
    float open = 1;
    for (int tap = 1; tap <= OCCLUSION_TAPS; ++tap) {
        const float way = view->reach * (tap * tap) / (float)(OCCLUSION_TAPS * OCCLUSION_TAPS) + 0.5f;
        const float3 at = p + way * direction / triple(view->spacing);
        if (!is_in_block(view, at) || is_cut_away(view, at)) break;
        const float value = value_at(view, samples, at);
        if (value >= view->highest) continue;
        open = fmin(open, (value - view->level) / (way * fmax(cosine, 0.3f)));
    }
    return clamp(open, 0.0f, 1.0f);
}

static inline float lit(const RenderView* view, __global const float* samples, float3 p, float3 direction) {
    float light = 1, way = 0.5f;
    for (int step = 0; step < SHADOW_STEPS; ++step) {
        const float3 at = p + way * direction / triple(view->spacing);
        if (!is_in_block(view, at)) break;
        const float sample = value_at(view, samples, at), value = sample - view->level;
        if (is_cut_away(view, at)) {
            way += 1;
            continue;
        }
        if (value < 0) return 0;
        if (sample < view->highest) light = fmin(light, SHADOW_SHARPNESS * value / way);
        way += value > 0.5f ? value : 0.5f;
    }
    return light;
}

// Each of a pixel's rays looks into one direction of the hemisphere, cosine-weighted, and at one point of the light.
static inline void shade(const RenderView* view, __global const float* samples, float3 point, int column, int row,
                         RenderHit* hit) {
    const float3 gradient = triple(hit->gradient);
    const float size = length(gradient);
    if (!(size > 0)) return;
    const float3 normal = gradient / size, light = triple(view->light);
    const int i = column % view->per_side, j = row % view->per_side;
    const float radius = sqrt((i + 0.5f) / view->per_side);
    const float angle = 6.2831853f * ((j + 0.5f) / view->per_side + 0.381966f * i);
    const float right = radius * cos(angle), up = radius * sin(angle);
    float3 u, v;
    frame_around(normal, &u, &v);
    const float cosine = sqrt(1 - radius * radius);
    const float3 lifted = point + normal / triple(view->spacing);  // by a voxel, out of the interpolant's waves
    hit->ambient = openness(view, samples, lifted, right * u + up * v + cosine * normal, cosine);
    frame_around(light, &u, &v);
    const float3 towards = normalize(light + view->light_spread * (right * u + up * v));
    hit->light = dot(normal, light) > 0 ? lit(view, samples, lifted, towards) : 0;
}

// One work-item a ray. Global size: (columns, rows of this launch).
__kernel void render_rays(RenderView given, int first_row, __global const float* samples, __global RenderHit* hits) {
    const RenderView view = given;
    const int column = get_global_id(0), row = first_row + get_global_id(1);
    if (column >= view.columns || row >= view.rows) return;
    const double3 origin = triple_of_doubles(view.origin) + column * triple_of_doubles(view.origin_right) +
                           row * triple_of_doubles(view.origin_down);
    const double3 unscaled = triple_of_doubles(view.direction) + column * triple_of_doubles(view.direction_right) +
                             row * triple_of_doubles(view.direction_down);
    const double3 spacing = convert_double3(triple(view.spacing));
    const double3 direction = unscaled / length(unscaled * spacing);  // t is in voxels
    const float rate = fmax(dot(fabs(convert_float3(direction * spacing)), triple(view.slope)), 1e-20f);

    const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    const Interval block = in_block(&view, o, d), cut = in_cut(&view, o, d);
    Interval before = block, after = block;
    if (cut.end > cut.begin) {
        before.end = fmin(block.end, cut.begin);
        if (cut.end > block.begin) {
            after.begin = cut.end;
            after.kind = cut.kind;
        }
    } else {
        after.end = -DBL_MAX;
    }

    RenderHit hit;
    hit.kind = CLSDF_RENDER_NOTHING;
    hit.light = hit.ambient = 1;
    hit.value = 0;
    hit.padding[0] = hit.padding[1] = 0;
    float3 point = (float3)(0), gradient = (float3)(0);
    if (march(&view, samples, origin, direction, rate, before, &hit, &point) ||
        march(&view, samples, origin, direction, rate, after, &hit, &point)) {
        gradient = gradient_at(&view, samples, point);
        hit.value = value_at(&view, samples, point);
    }
    hit.position[0] = point.x;
    hit.position[1] = point.y;
    hit.position[2] = point.z;
    hit.gradient[0] = gradient.x;
    hit.gradient[1] = gradient.y;
    hit.gradient[2] = gradient.z;
    if (hit.kind == CLSDF_RENDER_SURFACE) shade(&view, samples, point, column, row, &hit);
    hits[(size_t)get_global_id(1) * view.columns + column] = hit;
}
