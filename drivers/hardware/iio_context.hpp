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
/// each of connecting, describing and so on, which it does not let one change.
IioContextHandle open_iio_context(const std::string& uri);

/// An attribute's text, of the channel or, where that is null, of the device; empty when it cannot be read.
std::optional<std::string> iio_text(const iio_device* device, const iio_channel* channel,
                                    const char* attribute);
/// Likewise its first number, as the C locale writes it.
std::optional<double> iio_number(const iio_device* device, const iio_channel* channel, const char* attribute);
/// The device's own serial number, where it tells one.
std::optional<std::string> iio_serial(const iio_device* device);

}  // namespace shaker
