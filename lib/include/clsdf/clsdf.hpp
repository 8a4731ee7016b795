#pragma once

/// Everything but the reference (clsdf/reference.hpp) and pictures (clsdf/picture.hpp), which are targets of their own.
#include <clsdf/band.hpp>
#include <clsdf/bounding_solids.hpp>
#include <clsdf/box.hpp>
#include <clsdf/classification.hpp>
#include <clsdf/defects.hpp>
#include <clsdf/device.hpp>
#include <clsdf/distance_transform.hpp>
#include <clsdf/error.hpp>
#include <clsdf/field.hpp>
#include <clsdf/field_array.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/length.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/method.hpp>
#include <clsdf/shapes.hpp>
#include <clsdf/sign.hpp>
#include <clsdf/topology.hpp>
#include <clsdf/version.hpp>
