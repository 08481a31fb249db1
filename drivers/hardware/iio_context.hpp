#pragma once
// A connection to libiio: who owns it, how its errors are worded, how attributes are read.
#include <memory>
#include <optional>
#include <string>

struct iio_context;
struct iio_device;
struct iio_channel;

namespace shaker {

struct IioContextEnd {
    void operator()(iio_context* context) const noexcept;
};
using IioContextHandle = std::unique_ptr<iio_context, IioContextEnd>;

/// libiio's words for -errno.
std::string iio_words(int rc);
/// Throws DeviceError with the address and libiio's words. May block for as long as libiio likes: 5 s for
/// each of connecting, describing and so on, which it does not let one change. From the first call on the
/// process ignores SIGPIPE, unless it handles it: libiio's writes to a peer that is gone would end it.
IioContextHandle open_iio_context(const std::string& uri);

/// An attribute's text, of the channel or, where that is null, of the device; empty when it cannot be read.
std::optional<std::string> iio_text(const iio_device* device, const iio_channel* channel,
                                    const char* attribute);
/// Likewise its first number, as the C locale writes it.
std::optional<double> iio_number(const iio_device* device, const iio_channel* channel, const char* attribute);
/// Where a device's rate is to be read and set: an attribute of the device, of the channel, or of the trigger
/// that the device has now, as the driver's author liked.
struct IioRate {
    const iio_device* device = nullptr;    // or trigger
    const iio_channel* channel = nullptr;  // where set, the attribute is the channel's
    [[nodiscard]] bool exists() const noexcept { return device != nullptr; }
    /// Its text, and that of the rates to choose among; empty where not told.
    [[nodiscard]] std::optional<std::string> text() const;
    [[nodiscard]] std::optional<std::string> choice() const;
    [[nodiscard]] std::optional<double> hz() const;
    /// 0 or more, or -errno. Only where it exists.
    [[nodiscard]] long set(const std::string& hz) const;
};
IioRate iio_rate(const iio_device* device, const iio_channel* channel);
/// The trigger that the device has now, or null.
const iio_device* iio_trigger(const iio_device* device);
/// A C string of libiio's, which may be null: empty then.
std::string iio_string(const char* text);
/// The device's own serial number, where it tells one.
std::optional<std::string> iio_serial(const iio_device* device);

}  // namespace shaker
