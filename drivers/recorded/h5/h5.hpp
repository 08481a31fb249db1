#pragma once
// Owning HDF5 handles; typed reading and writing. hid_t is used only here.
#include <hdf5.h>

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace shaker::h5 {

/// Owns one HDF5 identifier of any kind.
class Handle {
public:
    Handle() = default;
    /// Takes ownership. Throws DeviceError with `what` when the call that created `id` failed.
    Handle(hid_t id, const std::string& what);
    Handle(Handle&& other) noexcept : id_{std::exchange(other.id_, H5I_INVALID_HID)} {}
    Handle& operator=(Handle&& other) noexcept;
    ~Handle();
    [[nodiscard]] hid_t get() const noexcept { return id_; }
    /// Releases ownership.
    [[nodiscard]] hid_t release() noexcept { return std::exchange(id_, H5I_INVALID_HID); }

private:
    hid_t id_ = H5I_INVALID_HID;
};

template <class T>
concept Element =
    std::same_as<T, double> || std::same_as<T, std::int64_t> || std::same_as<T, std::uint64_t> ||
    std::same_as<T, std::int32_t> || std::same_as<T, std::uint8_t> || std::same_as<T, std::uint16_t>;

/// The HDF5 type of a C++ type in memory; files use the same type, little-endian.
template <Element T>
hid_t type_of() noexcept;

/// Fixed-length UTF-8 of `bytes` bytes, null-padded.
Handle text_type(std::size_t bytes);

/// HDF5's text for the last error: the innermost message of its error stack.
std::string own_words();
/// Stops HDF5 from printing errors of this thread.
void be_quiet();
/// Throws DeviceError with `what` and HDF5's error text when a call failed.
void check(herr_t status, const std::string& what);

/// Creates a file that other processes may read while it grows, after let_others_read(). Replaces an existing
/// file: see FileLock::of_new(). Every object begins on its own page of the disk: a page torn by a power
/// failure damages no other object.
Handle create_file(const std::filesystem::path& file);
/// From now on no objects can be added to the file. No attribute may be open.
void let_others_read(hid_t file, const std::string& name);
/// Writes all data into the file. DeviceError for any failure of the disk since the file was opened: other
/// writing calls report none (see WrittenFile). The file stays as it was at the failure.
void flush(hid_t file, const std::string& name);
/// Returns when flushed data are on the disk; HDF5's own flush does not ensure this.
void sync(hid_t file, const std::string& name);
/// Closes the file and synchronises it to the disk. DeviceError when that fails or handles are still open.
void close_file(Handle file, const std::string& name);
/// Opens a copy of a file whose writer died, for writing. InputError when HDF5 cannot read it.
Handle open_to_mend(const std::filesystem::path& file);
enum class Access {
    finished,  // closed by its writer
    growing,   // still being written, or its writer died
};
/// Opens for reading only. InputError when it is missing, not HDF5, or was never closed.
Handle open_file(const std::filesystem::path& file, Access access = Access::finished);
/// Creates the group `path` below `parent` and missing groups on the way (NXcollection). nx_class may be
/// empty.
Handle make_group(hid_t parent, const std::string& path, const std::string& nx_class);

void set_attribute(hid_t object, const std::string& name, const std::string& text);
void set_attribute(hid_t object, const std::string& name, double value);
void set_attribute(hid_t object, const std::string& name, std::int64_t value);
void set_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);

/// Writes whole data sets. `shape`: its product is values.size(). `units` of a pure number: "1" or empty. A
/// text is a fixed-length string.
template <Element T>
void write(hid_t parent, const std::string& name, std::span<const T> values, std::vector<hsize_t> shape,
           const std::string& units);
/// Creates a data set for one value of a type and allocates it in the file.
Handle make_value(hid_t parent, const std::string& name, hid_t type);
void write_text(hid_t parent, const std::string& name, const std::string& text);
/// A column of fixed-length strings of the length of the longest.
void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts);

bool exists(hid_t parent, const std::string& path);
/// Throws InputError with the path when it is not a group.
Handle open_group(hid_t parent, const std::string& path);
/// Names of the objects in a group, in alphabetical order.
std::vector<std::string> names_in(hid_t parent, const std::string& path);

/// Reading. InputError with the path when the data set is missing, has another type than T or fixed-length
/// text, is stored in other files, compressed, damaged, or larger than `limit` elements or than the file can
/// hold. The size of the file bounds the memory.
///
/// Shape and element size of a data set.
struct Description {
    std::vector<hsize_t> shape;
    std::size_t element;  // bytes
};
Description description_of(hid_t parent, const std::string& path);
template <Element T>
std::vector<T> read(hid_t parent, const std::string& path, std::size_t limit = 400'000'000);
std::string read_text(hid_t parent, const std::string& path);
/// Elements of a data set in memory, of any type; `row`: bytes per row.
struct Bytes {
    std::vector<std::byte> values;
    std::size_t row = 1;
};
Bytes read_bytes(hid_t parent, const std::string& path);
/// Its first rows, as many as are readable: all of them unless its index is torn.
Bytes read_first_bytes(hid_t parent, const std::string& path);
std::vector<std::string> read_texts(hid_t parent, const std::string& path);
bool has_attribute(hid_t parent, const std::string& path, const std::string& name);
std::string read_attribute_text(hid_t parent, const std::string& path, const std::string& name);
double read_attribute(hid_t parent, const std::string& path, const std::string& name);
/// Reads row `index` along the first axis into `row`, whose size is the product of the other extents.
template <Element T>
void read_row(hid_t parent, const std::string& path, hsize_t index, std::span<T> row);

// Errors common to opening and reading files of unknown origin: an HDF5 error is the fault of the file.

/// Throws InputError naming the path.
[[noreturn]] void refuse(const std::string& path, const std::string& why);
/// A handle used for reading only; refuse() when `id` is invalid.
Handle readable(hid_t id, const std::string& path);
void readable(herr_t status, const std::string& path);
/// The reason for which HDF5 did not open `path`.
std::string why_not(hid_t parent, const std::string& path);

}  // namespace shaker::h5
