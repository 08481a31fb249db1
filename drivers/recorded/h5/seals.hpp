#pragma once
// Growing data sets of a recording and their seals: checksums that show which part of it is intact, however
// it ended.
//
// Each flush writes a seal: for every column that has grown, its number of rows and the CRC-32C of the bytes
// added since the previous seal; the last entry is for the seal itself. Data after the last whole seal are
// not verified.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// A data set of a recording that grows along its first axis while other processes read it.
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

struct SealEntry {
    static constexpr std::int64_t whole = -1;  // column number of the entry that ends a seal
    std::int64_t seal = 0;                     // counts from 1
    std::int64_t column = 0;                   // index into the list of columns
    std::int64_t rows = 0;  // of the column; in the last entry: number of entries of this seal before it
    /// Of the added bytes (unchecked: provisional column); in the last entry: of those entries.
    std::int64_t checksum = 0;
    static constexpr std::int64_t unchecked = -1;
};

class SealWriter {
public:
    /// Creates /entry/seals with the names of the columns (paths under /entry) in the order of their numbers.
    SealWriter(hid_t entry, const std::vector<std::string>& columns);
    /// Continues a file whose seals are to be rewritten.
    SealWriter(hid_t entry, std::size_t columns);
    /// Adds one column to the seal in progress if it has grown.
    void add(std::size_t column, hsize_t rows, std::int64_t checksum);
    /// Ends the seal and writes it, unless nothing has grown.
    void flush();

private:
    h5::Growing seal_, column_, rows_, checksum_;
    std::vector<SealEntry> entries_;
    std::vector<hsize_t> sealed_;  // number of rows, for each column
    std::int64_t number_ = 0;
};

/// A range of rows of a column with its checksum.
struct SealedPiece {
    hsize_t from = 0, to = 0;  // rows
    std::int64_t checksum = 0;
    std::int64_t seal = 0;
};
struct SealedColumn {
    std::string path;
    std::vector<SealedPiece> pieces;  // consecutive, from row 0
    /// Number of intact rows: those of the pieces before the first wrong one.
    [[nodiscard]] hsize_t good_rows(std::span<const std::byte> bytes, std::size_t row_bytes) const;
};
/// Contents of the seals of a file up to the first that is not whole. InputError when there is no list.
std::vector<SealedColumn> read_seals(hid_t entry);

}  // namespace shaker::h5
