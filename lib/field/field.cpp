#include "core/atomic_file.hpp"
#include "field/formats.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>

#include <fmt/format.h>

#include <filesystem>
#include <new>

namespace clsdf {

namespace fs = std::filesystem;

void Field::check_output(const std::string& path, const Outputs& outputs) {
    check_place_for(outputs, path, format_of(path, ErrorCode::unsupported));
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status))
        AtomicFile(std::string(path));  // without commit() it leaves nothing
}

void Field::write(const std::string& path) const {
    format_of(path, ErrorCode::unsupported);
    grid.validate();
    const std::size_t samples = grid.sample_count();
    const Outputs outputs = outputs_of(*this);
    const FieldSlab slab = slab_of(*this);
    for (const OutputKind& kind : kinds_of(outputs)) {
        const std::size_t values = kind.bytes(slab).size() / kind.sample_bytes();
        if (kind.bytes(slab).size() != samples * kind.sample_bytes())
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("field: {} has {} values, but the grid {} samples", kind.name, values, samples));
    }
    FieldWriter writer(path, *this, outputs);
    writer.append(slab);
    writer.finish();
}

Field Field::read(const std::string& path) {
    const Format& format = format_of(path, ErrorCode::unsupported);
    try {
        return format.read(path);
    } catch (const Error& error) {
        // A grid, band or sign rule of the file that makes no sense is the file's fault, not the caller's.
        if (error.code() != ErrorCode::invalid_argument) throw;
        throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", path, error.what()));
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::out_of_memory, fmt::format("{}: the field does not fit the memory", path));
    }
}

}  // namespace clsdf
