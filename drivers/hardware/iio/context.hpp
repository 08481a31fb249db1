#pragma once
// A connection to libiio: ownership, error texts, reading of attributes.
#include <memory>
#include <optional>
#include <string>

struct iio_context;
struct iio_device;
struct iio_channel;

namespace shaker::iio {

struct IioContextEnd {
    void operator()(iio_context* context) const noexcept;
};
using IioContextHandle = std::unique_ptr<iio_context, IioContextEnd>;

/// libiio's text for -errno.
std::string iio_words(int rc);
/// Opens a context. Throws DeviceError with the address and libiio's text. May block for libiio's time-outs:
/// 5 s for each step such as connecting or describing, which cannot be changed. After the first call the
/// process ignores SIGPIPE unless it handles the signal: libiio's writes to a closed connection would end the
/// process.
IioContextHandle open_iio_context(const std::string& uri);

/// Text of an attribute of the channel, or of the device if `channel` is null; empty when it cannot be read.
std::optional<std::string> iio_text(const iio_device* device, const iio_channel* channel,
                                    const char* attribute);
/// First number of the attribute, in the C locale.
std::optional<double> iio_number(const iio_device* device, const iio_channel* channel, const char* attribute);
/// The attribute of a device's sampling rate. Depending on the kernel driver it belongs to the device, the
/// channel, or the device's present trigger.
struct IioRate {
    const iio_device* device = nullptr;    // or its trigger
    const iio_channel* channel = nullptr;  // if set, the attribute is the channel's
    [[nodiscard]] bool exists() const noexcept { return device != nullptr; }
    /// Its text, and that of the available rates; empty if not available.
    [[nodiscard]] std::optional<std::string> text() const;
    [[nodiscard]] std::optional<std::string> choice() const;
    [[nodiscard]] std::optional<double> hz() const;
    /// 0 or more, or -errno. Requires exists().
    [[nodiscard]] long set(const std::string& hz) const;
};
IioRate iio_rate(const iio_device* device, const iio_channel* channel);
/// The device's present trigger, or null.
const iio_device* iio_trigger(const iio_device* device);
/// A C string of libiio; empty for null.
std::string iio_string(const char* text);
/// The device's serial number; empty if it has none.
std::optional<std::string> iio_serial(const iio_device* device);

}  // namespace shaker::iio
