#pragma once

#include "option_values.hpp"
#include "options.hpp"
#include "report.hpp"

#include <optional>
#include <string>
#include <vector>

/// Results at points that "clsdf check" judges: names of files, empty unless given.
struct PointsToCheck {
    std::string points;
    std::string distances;
    std::string closest;
    std::string gradients;
    std::string triangles;
    SignChoice sign;
    std::optional<double> tolerance{};

    bool are_given() const { return !points.empty(); }
};

/// Adds --points and the options that need it.
void add_options_of_points(Parser& parser, PointsToCheck& points);

/// Judges the results and puts the report into the result. Throws Error.
ExitStatus check_points(const PointsToCheck& given, const std::vector<std::string>& meshes, const MeshReading& reading,
                        bool positive_inside, const std::optional<double>& floor, clsdf::Surface surface,
                        Report& report);
