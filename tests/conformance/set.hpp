#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace clsdf::test {

/// A case of the conformance set (conformance/README.md).
struct ConformanceCase {
    std::filesystem::path folder;
    nlohmann::json answers;

    std::string name() const { return answers["name"]; }
    bool asks(const std::string& what) const {
        for (const std::string word : answers["asks"])
            if (word == what) return true;
        return false;
    }
};

/// The cases that conformance/make.py wrote to the folder, in order.
inline std::vector<ConformanceCase> conformance_cases(const std::filesystem::path& folder) {
    std::vector<ConformanceCase> cases;
    std::ifstream index(folder / "index.json");
    for (const nlohmann::json& about : nlohmann::json::parse(index)) {
        const std::filesystem::path path = folder / about["name"].get<std::string>();
        std::ifstream answers(path / "answers.json");
        cases.push_back({path, nlohmann::json::parse(answers)});
    }
    return cases;
}

}  // namespace clsdf::test
