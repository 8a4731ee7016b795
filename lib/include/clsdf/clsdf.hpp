#pragma once

/// The core library, clsdf::clsdf. Files (clsdf/mesh_files.hpp, clsdf/io.hpp), pictures (clsdf/picture.hpp), the
/// published methods (clsdf/papers.hpp) and the reference (clsdf/reference.hpp) are separate targets. clsdf/eigen.hpp
/// needs Eigen. clsdf/tuning.hpp is for measuring.
#include <clsdf/arrays.hpp>
#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>
#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/fractions.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/link_plan.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/plan.hpp>
#include <clsdf/point_plan.hpp>
#include <clsdf/scene.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/sparse.hpp>
#include <clsdf/sparse_plan.hpp>
#include <clsdf/topology.hpp>
#include <clsdf/version.hpp>
