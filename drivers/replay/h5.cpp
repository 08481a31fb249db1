#include "drivers/replay/h5.hpp"

#include <algorithm>
#include <numeric>

#include "drivers/errors.hpp"

namespace shaker::h5 {

namespace {

Handle plist(hid_t kind) { return {H5Pcreate(kind), "property list"}; }

Handle fixed_text(std::size_t size) {
    Handle type{H5Tcopy(H5T_C_S1), "string type"};
    check(H5Tset_size(type.get(), std::max<std::size_t>(1, size)), "string size");
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "string character set");
    return type;
}

// Texts behind each other, each as long as the longest.
std::pair<std::size_t, std::string> as_block(const std::vector<std::string>& texts) {
    std::size_t longest = 1;
    for (const std::string& t : texts) longest = std::max(longest, t.size());
    std::string block;
    for (std::string t : texts) {
        t.resize(longest, '\0');
        block += t;
    }
    return {longest, block};
}

}  // namespace

std::string own_words() {
    std::string words;
    H5Ewalk2(
        H5E_DEFAULT, H5E_WALK_UPWARD,
        [](unsigned, const H5E_error2_t* e, void* out) -> herr_t {
            auto& text = *static_cast<std::string*>(out);
            if (text.empty() && e->desc != nullptr) text = e->desc;
            return 0;
        },
        &words);
    return words.empty() ? "unknown HDF5 error" : words;
}

// HDF5 prints its error stack by itself unless told not to; what it says is thrown instead.
void be_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle::Handle(hid_t id, const std::string& what) : id_{id} {
    if (id < 0) throw DeviceError{what + ": " + own_words()};
}

Handle& Handle::operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
}

Handle::~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
}

void check(herr_t status, const std::string& what) {
    if (status < 0) throw DeviceError{what + ": " + own_words()};
}

template <>
hid_t type_of<double>() noexcept {
    return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::int64_t>() noexcept {
    return H5T_NATIVE_INT64;
}
template <>
hid_t type_of<std::uint64_t>() noexcept {
    return H5T_NATIVE_UINT64;
}
template <>
hid_t type_of<std::int32_t>() noexcept {
    return H5T_NATIVE_INT32;
}
template <>
hid_t type_of<std::uint8_t>() noexcept {
    return H5T_NATIVE_UINT8;
}
template <>
hid_t type_of<std::uint16_t>() noexcept {
    return H5T_NATIVE_UINT16;
}

Handle create_file(const std::filesystem::path& file) {
    be_quiet();
    const Handle access = plist(H5P_FILE_ACCESS);
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST), file.string());
    const Handle create = plist(H5P_FILE_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), file.string());  // same content, same bytes
    return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, create.get(), access.get()), file.string()};
}

Handle make_group(hid_t parent, const std::string& path, const std::string& nx_class) {
    // Groups on the way are made one by one: made by HDF5 itself they would carry the time of day.
    for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1))
        if (!exists(parent, path.substr(0, end))) make_group(parent, path.substr(0, end), "NXcollection");
    const Handle create = plist(H5P_GROUP_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), path);
    Handle group{H5Gcreate2(parent, path.c_str(), H5P_DEFAULT, create.get(), H5P_DEFAULT), path};
    if (!nx_class.empty()) set_attribute(group.get(), "NX_class", nx_class);
    return group;
}

void set_attribute(hid_t object, const std::string& name, const std::string& text) {
    const Handle type = fixed_text(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Awrite(a.get(), type.get(), padded.data()), name);
}

void set_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
    const auto [longest, block] = as_block(texts);
    const Handle type = fixed_text(longest);
    const hsize_t count = texts.size();
    const Handle space{H5Screate_simple(1, &count, nullptr), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    check(H5Awrite(a.get(), type.get(), block.data()), name);
}

void set_attribute(hid_t object, const std::string& name, double value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                   name};
    check(H5Awrite(a.get(), H5T_NATIVE_DOUBLE, &value), name);
}

void set_attribute(hid_t object, const std::string& name, std::int64_t value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                   name};
    check(H5Awrite(a.get(), H5T_NATIVE_INT64, &value), name);
}

template <Element T>
void write(hid_t parent, const std::string& name, std::span<const T> values, std::vector<hsize_t> shape,
           const std::string& units) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{shape.empty()
                           ? H5Screate(H5S_SCALAR)
                           : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    if (!values.empty())
        check(H5Dwrite(set.get(), type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
    set_attribute(set.get(), "units", units.empty() ? "1" : units);
}

void write_text(hid_t parent, const std::string& name, const std::string& text) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle type = fixed_text(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()), name);
}

void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const auto [longest, block] = as_block(texts);
    const Handle type = fixed_text(longest);
    const hsize_t count = texts.size();
    const Handle space{H5Screate_simple(1, &count, nullptr), name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    if (!texts.empty())
        check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), name);
}

template <Element T>
Appender<T>::Appender(hid_t parent, const std::string& name, std::vector<hsize_t> row, hsize_t chunk,
                      const std::string& units)
    : extent_{std::move(row)}, chunk_rows_{static_cast<std::size_t>(chunk)} {
    row_size_ = std::accumulate(extent_.begin(), extent_.end(), std::size_t{1}, std::multiplies<>{});
    extent_.insert(extent_.begin(), 0);
    std::vector<hsize_t> most = extent_, chunks = extent_;
    most[0] = H5S_UNLIMITED;
    chunks[0] = chunk;
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_chunk(create.get(), static_cast<int>(chunks.size()), chunks.data()), name);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{H5Screate_simple(static_cast<int>(extent_.size()), extent_.data(), most.data()), name};
    set_ = {
        H5Dcreate2(parent, name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    set_attribute(set_.get(), "units", units.empty() ? "1" : units);
    waiting_.reserve(row_size_ * chunk_rows_);
}

template <Element T>
void Appender<T>::append(std::span<const T> rows) {
    waiting_.insert(waiting_.end(), rows.begin(), rows.end());
    if (waiting_.size() >= row_size_ * chunk_rows_) flush();
}

template <Element T>
void Appender<T>::flush() {
    if (waiting_.empty()) return;
    std::vector<hsize_t> start(extent_.size(), 0), count = extent_;
    start[0] = extent_[0];
    count[0] = waiting_.size() / row_size_;
    extent_[0] += count[0];
    check(H5Dset_extent(set_.get(), extent_.data()), "growing a stream");
    const Handle space{H5Dget_space(set_.get()), "stream"};
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          "stream");
    const Handle memory{H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), "stream"};
    check(H5Dwrite(set_.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, waiting_.data()),
          "stream");
    waiting_.clear();
}

template class Appender<double>;
template class Appender<std::int64_t>;
template class Appender<std::int32_t>;
template class Appender<std::uint8_t>;
template class Appender<std::uint16_t>;
template void write(hid_t, const std::string&, std::span<const double>, std::vector<hsize_t>,
                    const std::string&);
template void write(hid_t, const std::string&, std::span<const std::int64_t>, std::vector<hsize_t>,
                    const std::string&);
template void write(hid_t, const std::string&, std::span<const std::uint64_t>, std::vector<hsize_t>,
                    const std::string&);

}  // namespace shaker::h5
