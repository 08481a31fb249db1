#include "drivers/replay/growing.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/replay/crc32c.hpp"

namespace shaker::h5 {

Growing::Growing(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> row, hsize_t chunk,
                 const std::string& units)
    : name_{name}, type_{H5Tcopy(type), name}, extent_{std::move(row)} {
    row_bytes_ = H5Tget_size(type);
    for (const hsize_t n : extent_) row_bytes_ *= n;
    chunk_bytes_ = row_bytes_ * chunk;
    extent_.insert(extent_.begin(), 0);
    std::vector<hsize_t> most = extent_, chunks = extent_;
    most[0] = H5S_UNLIMITED;
    chunks[0] = chunk;
    const Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
    check(H5Pset_chunk(create.get(), static_cast<int>(chunks.size()), chunks.data()), name);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{H5Screate_simple(static_cast<int>(extent_.size()), extent_.data(), most.data()), name};
    set_ = {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
    if (H5Tget_class(type) != H5T_STRING)
        set_attribute(set_.get(), "units", units.empty() ? std::string{"1"} : units);
}

Growing::Growing(hid_t parent, const std::string& path)
    : name_{path}, set_{H5Dopen2(parent, path.c_str(), H5P_DEFAULT), path} {
    type_ = {H5Dget_type(set_.get()), path};
    const Handle space{H5Dget_space(set_.get()), path};
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1) throw InputError{"recording: \"" + path + "\" is not a column"};
    std::vector<hsize_t> most(static_cast<std::size_t>(rank));
    extent_.resize(most.size());
    check(H5Sget_simple_extent_dims(space.get(), extent_.data(), most.data()), path);
    if (most[0] != H5S_UNLIMITED) throw InputError{"recording: \"" + path + "\" does not grow"};
    row_bytes_ = H5Tget_size(type_.get());
    for (std::size_t axis = 1; axis < extent_.size(); ++axis) row_bytes_ *= extent_[axis];
    chunk_bytes_ = row_bytes_;
}

void Growing::cut(hsize_t rows, std::uint32_t checksum) {
    if (rows != extent_[0]) {
        extent_[0] = rows;
        check(H5Dset_extent(set_.get(), extent_.data()), name_);
    }
    checksum_ = checksum;
}

void Growing::add(std::span<const std::byte> rows) {
    checksum_ = crc32c(rows, checksum_);
    waiting_.insert(waiting_.end(), rows.begin(), rows.end());
    if (waiting_.size() >= chunk_bytes_) flush();
}

void Growing::append_text(const std::string& text) {
    std::string row = text.substr(0, row_bytes_);
    row.resize(row_bytes_, '\0');
    add(std::as_bytes(std::span{row}));
}

hsize_t Growing::rows() const noexcept { return extent_[0] + waiting_.size() / row_bytes_; }

void Growing::write(hsize_t first, std::span<const std::byte> rows) {
    std::vector<hsize_t> start(extent_.size(), 0), count = extent_;
    start[0] = first;
    count[0] = rows.size() / row_bytes_;
    const Handle space{H5Dget_space(set_.get()), name_};
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          name_);
    const Handle memory{H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), name_};
    check(H5Dwrite(set_.get(), type_.get(), memory.get(), space.get(), H5P_DEFAULT, rows.data()), name_);
}

void Growing::flush() {
    if (waiting_.empty()) return;
    const hsize_t first = extent_[0];
    extent_[0] = rows();
    check(H5Dset_extent(set_.get(), extent_.data()), name_);
    write(first, waiting_);
    waiting_.clear();
}

void Growing::replace(std::span<const std::byte> rows) {
    if (!waiting_.empty() || rows.size() != extent_[0] * row_bytes_)
        throw DeviceError{name_ + ": " + std::to_string(rows.size() / row_bytes_) + " rows in place of " +
                          std::to_string(this->rows())};
    if (rows.empty()) return;
    write(0, rows);
    checksum_ = crc32c(rows);
}

}  // namespace shaker::h5
