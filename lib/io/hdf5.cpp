#include "io/hdf5.hpp"

namespace clsdf::hdf5 {
namespace {

std::mutex& one_at_a_time() {
    static std::mutex mutex;
    return mutex;
}

/// HDF5 1.10 does not free the header of an object that it finds damaged. At the end of the process it waits for the
/// header in vain and prints a message, unless printing is off.
class QuietEnd {
public:
    QuietEnd() { H5open(); }  // destructors run in reverse order
    ~QuietEnd() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }
    QuietEnd(const QuietEnd&) = delete;
    QuietEnd& operator=(const QuietEnd&) = delete;
};

}  // namespace

Session::Session() : lock_(one_at_a_time()) {
    static const QuietEnd quiet_end;
    H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() {
    H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
}

std::string Session::reason() {
    std::string text = "an unknown error";
    // The first one is where it began.
    const H5E_walk2_t take = [](unsigned, const H5E_error2_t* error, void* result) -> herr_t {
        if (error->desc != nullptr) *static_cast<std::string*>(result) = error->desc;
        return 1;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &text);
    return text;
}

Handle access() {
    Handle list(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(list.get(), false, true);
#endif
    return list;
}

}  // namespace clsdf::hdf5
