#pragma once
// A data set of a recording that grows along its first axis while others read it.
#include "drivers/replay/h5.hpp"

namespace shaker::h5 {

class Growing {
public:
    /// type: of an element; row: extents of the other axes; chunk: rows that are stored together. DeviceError
    /// when it cannot be made.
    Growing(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> row, hsize_t chunk,
            const std::string& units);

    /// One that is there, of which only the first rows are kept, to be gone on with; what was appended in
    /// them has this checksum. Where its index is torn it is made anew. InputError when it does not grow.
    Growing(hid_t parent, const std::string& path, hsize_t rows, std::uint32_t checksum);

    /// Adds whole rows; they are written when a chunk of them has gathered, or by flush().
    template <Element T>
    void append(std::span<const T> rows) {
        add(std::as_bytes(rows));
    }
    template <Element T>
    void append(T value) {
        append(std::span<const T>{&value, 1});
    }
    /// Cut or padded to the length of the column's texts.
    void append_text(const std::string& text);
    void flush();
    /// Other values in place of all rows, which have been flushed.
    void replace(std::span<const std::byte> rows);

    [[nodiscard]] hsize_t rows() const noexcept;
    /// Takes all rows out again.
    void clear();
    /// Of all bytes appended since the last call.
    [[nodiscard]] std::uint32_t take_checksum() noexcept { return std::exchange(checksum_, 0); }

private:
    [[nodiscard]] bool resize(hsize_t rows) noexcept;
    [[nodiscard]] bool takes_rows();
    void remake(hid_t parent);
    void add(std::span<const std::byte> rows);
    void write(hsize_t first, std::span<const std::byte> rows);

    std::string name_;
    Handle type_, set_;
    std::vector<hsize_t> extent_;  // extent_[0]: rows in the file
    std::size_t row_bytes_ = 0, chunk_bytes_ = 0;
    std::vector<std::byte> waiting_;
    std::uint32_t checksum_ = 0;
};

}  // namespace shaker::h5
