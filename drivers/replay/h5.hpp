#pragma once
// Owning HDF5 handles and typed reading and writing. hid_t appears here and nowhere else.
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
    /// Takes ownership; throws DeviceError naming `what` when the call that made `id` failed.
    Handle(hid_t id, const std::string& what);
    Handle(Handle&& other) noexcept : id_{std::exchange(other.id_, H5I_INVALID_HID)} {}
    Handle& operator=(Handle&& other) noexcept;
    ~Handle();
    [[nodiscard]] hid_t get() const noexcept { return id_; }
    /// Gives it up to the caller.
    [[nodiscard]] hid_t release() noexcept { return std::exchange(id_, H5I_INVALID_HID); }

private:
    hid_t id_ = H5I_INVALID_HID;
};

template <class T>
concept Element =
    std::same_as<T, double> || std::same_as<T, std::int64_t> || std::same_as<T, std::uint64_t> ||
    std::same_as<T, std::int32_t> || std::same_as<T, std::uint8_t> || std::same_as<T, std::uint16_t>;

/// HDF5's name for a C++ type in memory; files hold the same, little-endian.
template <Element T>
hid_t type_of() noexcept;

/// Fixed-length UTF-8 of `bytes`, ended by zeros.
Handle text_type(std::size_t bytes);

/// HDF5's own words for what went wrong last: the innermost message of its error stack.
std::string own_words();
/// Keeps HDF5 from printing errors of this thread by itself.
void be_quiet();
/// Throws DeviceError with `what` and HDF5's own words when a call failed.
void check(herr_t status, const std::string& what);

/// A file that others may read while it grows, once let_others_read() was called. Every object begins on a
/// page of the disk of its own: a page that was half written when the power went takes no other object with
/// it.
Handle create_file(const std::filesystem::path& file);
/// From now on the file takes no new objects. No attribute may be open.
void let_others_read(hid_t file);
/// What was flushed is on the disk when this returns: HDF5's own flush does not see to that.
void sync(hid_t file, const std::string& name);
/// Closes it for good and sees it onto the disk. DeviceError when that fails, or when handles are still open.
void close_file(Handle file, const std::string& name);
/// A copy of a file whose writer died, to be written. InputError when HDF5 cannot make sense of it.
Handle open_to_mend(const std::filesystem::path& file);
enum class Access {
    finished,  // one that was closed
    growing,   // one that is being written, or whose writer died
};
/// Read-only; InputError when it is missing, not HDF5, or was never closed.
Handle open_file(const std::filesystem::path& file, Access access = Access::finished);
/// Group at `path` below `parent`, with the groups on the way (NXcollection); `nx_class` is left out when
/// empty.
Handle make_group(hid_t parent, const std::string& path, const std::string& nx_class);

void set_attribute(hid_t object, const std::string& name, const std::string& text);
void set_attribute(hid_t object, const std::string& name, double value);
void set_attribute(hid_t object, const std::string& name, std::int64_t value);
void set_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts);

/// Whole data sets. `shape` is the product of values.size(); units of a pure number: "1" or empty; a text is
/// a fixed-length string.
template <Element T>
void write(hid_t parent, const std::string& name, std::span<const T> values, std::vector<hsize_t> shape,
           const std::string& units);
/// A data set for one value of a type, with room in the file.
Handle make_value(hid_t parent, const std::string& name, hid_t type);
void write_text(hid_t parent, const std::string& name, const std::string& text);
/// A column of fixed-length strings, all as long as the longest.
void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts);

bool exists(hid_t parent, const std::string& path);
/// Throws InputError naming the path when it is not a group.
Handle open_group(hid_t parent, const std::string& path);
/// Names of what is in a group, in alphabetical order.
std::vector<std::string> names_in(hid_t parent, const std::string& path);

/// Reading throws InputError naming the path when it is missing, of another type than T or a fixed-length
/// text, kept in other files, compressed, damaged, or larger than `limit` elements or than the file can hold:
/// what is taken from memory is bounded by the size of the file.
///
/// Shape and size of the elements of a data set.
struct Description {
    std::vector<hsize_t> shape;
    std::size_t element;  // bytes
};
Description description_of(hid_t parent, const std::string& path);
template <Element T>
std::vector<T> read(hid_t parent, const std::string& path, std::size_t limit = 400'000'000);
std::string read_text(hid_t parent, const std::string& path);
/// The elements of a data set as they are in memory, whatever their type, and the bytes of a row.
struct Bytes {
    std::vector<std::byte> values;
    std::size_t row = 1;
};
Bytes read_bytes(hid_t parent, const std::string& path);
/// Its first rows, as many as can be read: all of them, unless its index is torn.
Bytes read_first_bytes(hid_t parent, const std::string& path);
std::vector<std::string> read_texts(hid_t parent, const std::string& path);
bool has_attribute(hid_t parent, const std::string& path, const std::string& name);
std::string read_attribute_text(hid_t parent, const std::string& path, const std::string& name);
double read_attribute(hid_t parent, const std::string& path, const std::string& name);
/// Row `index` along the first axis into `row`, whose size is the product of the other extents.
template <Element T>
void read_row(hid_t parent, const std::string& path, hsize_t index, std::span<T> row);

}  // namespace shaker::h5
