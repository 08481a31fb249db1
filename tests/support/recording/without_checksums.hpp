#pragma once
// A recording in the format of HDF5 before version 1.8: its structure has no checksums, so that HDF5 itself
// does not detect damage.
#include <filesystem>
#include <vector>

#include "drivers/recorded/h5/h5.hpp"

namespace shaker::test {

inline herr_t copy_attribute(hid_t from, const char* name, const H5A_info_t*, void* to) {
    const h5::Handle a{H5Aopen(from, name, H5P_DEFAULT), name};
    const h5::Handle type{H5Aget_type(a.get()), name};
    const h5::Handle space{H5Aget_space(a.get()), name};
    const auto values = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
    std::vector<char> bytes(values * H5Tget_size(type.get()));
    h5::check(H5Aread(a.get(), type.get(), bytes.data()), name);
    const h5::Handle b{
        H5Acreate2(*static_cast<hid_t*>(to), name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    return H5Awrite(b.get(), type.get(), bytes.data());
}

inline h5::Handle copy_dataset(hid_t from, hid_t file, const char* name) {
    const h5::Handle type{H5Dget_type(from), name};
    const h5::Handle space{H5Dget_space(from), name};
    const h5::Handle was{H5Dget_create_plist(from), name}, create{H5Pcreate(H5P_DATASET_CREATE), name};
    if (H5Pget_layout(was.get()) == H5D_CHUNKED) {  // of the old kind
        std::vector<hsize_t> chunk(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
        H5Pget_chunk(was.get(), static_cast<int>(chunk.size()), chunk.data());
        h5::check(H5Pset_chunk(create.get(), static_cast<int>(chunk.size()), chunk.data()), name);
    }
    h5::Handle set{H5Dcreate2(file, name, type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
                   name};
    const auto values = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
    std::vector<char> bytes(values * H5Tget_size(type.get()));
    if (!bytes.empty()) {
        h5::check(H5Dread(from, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), name);
        h5::check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), name);
    }
    return set;
}

inline herr_t copy_object(hid_t root, const char* name, const H5O_info_t* info, void* out) {
    const hid_t file = *static_cast<hid_t*>(out);
    if (std::string_view{name} == ".") return 0;
    const h5::Handle from{H5Oopen(root, name, H5P_DEFAULT), name};
    const h5::Handle to = info->type == H5O_TYPE_DATASET ? copy_dataset(from.get(), file, name)
                                                         : h5::make_group(file, name, "");
    hid_t target = to.get();
    return H5Aiterate2(from.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr, copy_attribute, &target);
}

inline void copy_without_checksums(const std::filesystem::path& from, const std::filesystem::path& to) {
    const h5::Handle source = h5::open_file(from);
    const h5::Handle copy{H5Fcreate(to.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), to.string()};
    hid_t target = copy.get();
    h5::check(H5Ovisit2(source.get(), H5_INDEX_NAME, H5_ITER_INC, copy_object, &target, H5O_INFO_BASIC),
              "copying");
}

}  // namespace shaker::test
