#pragma once

#include "acceptance/cost.hpp"
#include "acceptance/run.hpp"

#include <string>
#include <vector>

namespace clsdf::acceptance {

/// The results of a run.
struct Record {
    std::string command;
    std::string commit;  ///< empty if not known
    std::string device;
    std::vector<Result> results;
    std::vector<CostLimit> costs;
    std::vector<std::string> unreadable;
    double seconds = 0;

    bool passed() const;
};

/// Rows for the terminal.
std::string heading();
std::string row(const Result& result);
std::string row(const CostLimit& limit);

/// The faults, a line each; may be empty.
std::string explain(const Result& result);

/// The results in about ten lines of Markdown, with the machine and the date. Throws Error(output_failure).
void write_summary(const Record& record, const std::string& path);

/// The same, then kind by kind and field by field. Throws Error(output_failure).
void write_fields(const Record& record, const std::string& path);

}  // namespace clsdf::acceptance
