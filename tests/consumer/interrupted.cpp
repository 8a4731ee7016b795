#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <cstdlib>
#include <filesystem>
#include <iostream>

// A program that ends while it writes a field: interrupted FOLDER. With shared libraries, too, there is one list of
// unfinished files.
int main(int count, char** arguments) try {
    if (count != 2) return 2;
    const std::filesystem::path folder = arguments[1];
    std::filesystem::create_directories(folder);
    const clsdf::Band band = clsdf::Band::symmetric(0.1);
    clsdf::FieldDescription field;
    field.grid = clsdf::Grid::around(clsdf::make_shape("cube"), 8, band);
    field.band = band;
    const clsdf::FieldWriter writer((folder / "field.nrrd").string(), field);
    const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder), {}); };
    const auto before = files();
    clsdf::abandon_unfinished_files();
    std::cout << before << " unfinished files, then " << files() << std::endl;
    std::_Exit(before > 0 && files() == 0 ? 0 : 3);
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
