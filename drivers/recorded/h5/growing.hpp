#pragma once
// Growing: a data set of a recording that grows along its first axis while other processes read it.
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

class Growing {
public:
    /// type: of an element; row: extents of the other axes; chunk: rows per chunk. DeviceError when it cannot
    /// be created.
    Growing(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> row, hsize_t chunk,
            const std::string& units);

    /// Continues an existing data set, cut to its first `rows` rows, whose appended bytes have this checksum.
    /// Recreated if its index is torn. InputError when it cannot grow.
    Growing(hid_t parent, const std::string& path, hsize_t rows, std::uint32_t checksum);

    /// Adds whole rows; they are written when a chunk is full, or by flush().
    template <Element T>
    void append(std::span<const T> rows) {
        append_bytes(std::as_bytes(rows));
    }
    template <Element T>
    void append(T value) {
        append(std::span<const T>{&value, 1});
    }
    /// Whole rows as they are in memory.
    void append_bytes(std::span<const std::byte> rows);
    /// Cut or padded to the column's text length.
    void append_text(const std::string& text);
    void flush();
    /// Replaces the values of all rows. Requires flush().
    void replace(std::span<const std::byte> rows);

    /// Reads rows that append() has added, from `first` on; the size of `rows` gives their number.
    /// DeviceError when they do not exist or the disk fails.
    template <Element T>
    void read(hsize_t first, std::span<T> rows) {
        read_bytes(first, std::as_writable_bytes(rows));
    }
    void read_bytes(hsize_t first, std::span<std::byte> rows);

    [[nodiscard]] hsize_t rows() const noexcept;
    /// Removes all rows.
    void clear();
    /// Checksum of all bytes appended since the last call.
    [[nodiscard]] std::uint32_t take_checksum() noexcept { return std::exchange(checksum_, 0); }

private:
    [[nodiscard]] bool resize(hsize_t rows) noexcept;
    [[nodiscard]] bool takes_rows();
    void remake(hid_t parent);
    void write(hsize_t first, std::span<const std::byte> rows);
    [[nodiscard]] std::pair<Handle, Handle> spaces(hsize_t first, hsize_t rows) const;

    std::string name_;
    Handle type_, set_;
    std::vector<hsize_t> extent_;  // extent_[0]: number of rows in the file
    std::size_t row_bytes_ = 0, chunk_bytes_ = 0;
    std::vector<std::byte> waiting_;
    std::uint32_t checksum_ = 0;
};

}  // namespace shaker::h5
