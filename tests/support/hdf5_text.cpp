#include "tests/support/hdf5_text.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <cstring>
#include <span>
#include <vector>

#include "drivers/recorded/h5/crc32c.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::test {

namespace {

using Bytes = std::vector<std::byte>;

template <class T>
T number_in(const Bytes& bytes) {
    T value{};
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

std::string type_name(hid_t type) {
    const std::size_t bits = 8 * H5Tget_size(type);
    switch (H5Tget_class(type)) {
        case H5T_STRING:
            return fmt::format("text{}", bits / 8);
        case H5T_FLOAT:
            return fmt::format("float{}", bits);
        case H5T_INTEGER:
            return fmt::format("{}int{}", H5Tget_sign(type) == H5T_SGN_NONE ? "u" : "", bits);
        default:
            return fmt::format("bytes{}", bits / 8);
    }
}

/// A single number or text in figures, anything else as a checksum.
std::string value_text(hid_t type, hid_t space, const Bytes& bytes) {
    const bool single = H5Sget_simple_extent_npoints(space) == 1;
    if (H5Tget_class(type) == H5T_STRING && single) {
        const std::string text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
        return '"' + text.substr(0, text.find('\0')) + '"';
    }
    if (single && H5Tequal(type, H5T_IEEE_F64LE) > 0) return fmt::format("{}", number_in<double>(bytes));
    if (single && H5Tequal(type, H5T_STD_I64LE) > 0) return fmt::format("{}", number_in<std::int64_t>(bytes));
    return fmt::format("crc32c {:08x}", h5::crc32c(std::span{bytes}));
}

std::string shape_text(hid_t space) {
    std::vector<hsize_t> shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, shape.data(), nullptr);
    return shape.empty() ? "" : fmt::format("[{}]", fmt::join(shape, ", "));
}

template <class Read>
std::string value_of(const h5::Handle& type, const h5::Handle& space, Read read) {
    const auto count = static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
    Bytes bytes(count * H5Tget_size(type.get()));
    if (!bytes.empty()) h5::check(read(bytes.data()), "values");
    return fmt::format("{}{} {}", type_name(type.get()), shape_text(space.get()),
                       value_text(type.get(), space.get(), bytes));
}

herr_t add_attribute(hid_t object, const char* name, const H5A_info_t* /*info*/, void* out) {
    const h5::Handle attribute{H5Aopen(object, name, H5P_DEFAULT), name};
    const h5::Handle type{H5Aget_type(attribute.get()), name}, space{H5Aget_space(attribute.get()), name};
    *static_cast<std::string*>(out) += fmt::format("    {}: {}\n", name, value_of(type, space, [&](void* to) {
                                                       return H5Aread(attribute.get(), type.get(), to);
                                                   }));
    return 0;
}

herr_t add_object(hid_t top, const char* name, const H5O_info_t* info, void* out) {
    std::string& text = *static_cast<std::string*>(out);
    text += name;
    const h5::Handle object{H5Oopen(top, name, H5P_DEFAULT), name};
    if (info->type == H5O_TYPE_DATASET) {
        const h5::Handle type{H5Dget_type(object.get()), name}, space{H5Dget_space(object.get()), name};
        text += ' ' + value_of(type, space, [&](void* to) {
                    return H5Dread(object.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, to);
                });
    }
    text += '\n';
    return H5Aiterate2(object.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr, &add_attribute, out);
}

}  // namespace

std::string text_of_hdf5(const std::filesystem::path& file) {
    std::string text;
    const h5::Handle root = h5::open_file(file);
    h5::check(H5Ovisit2(root.get(), H5_INDEX_NAME, H5_ITER_INC, &add_object, &text, H5O_INFO_BASIC),
              file.string());
    return text;
}

}  // namespace shaker::test
