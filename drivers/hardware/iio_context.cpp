#include "drivers/hardware/iio_context.hpp"

#include <iio.h>

#include <array>
#include <cerrno>
#include <charconv>

#include "drivers/errors.hpp"

namespace shaker {

void IioContextEnd::operator()(iio_context* context) const noexcept { iio_context_destroy(context); }

std::string iio_words(int rc) {
    std::array<char, 256> words{};
    iio_strerror(rc < 0 ? -rc : rc, words.data(), words.size());
    return words.data();
}

IioContextHandle open_iio_context(const std::string& uri) {
    IioContextHandle context{iio_create_context_from_uri(uri.c_str())};
    if (!context) throw DeviceError{uri + ": " + iio_words(errno)};
    return context;
}

std::optional<std::string> iio_text(const iio_device* device, const iio_channel* channel,
                                    const char* attribute) {
    std::array<char, 1024> text{};
    const auto size = channel != nullptr
                          ? iio_channel_attr_read(channel, attribute, text.data(), text.size() - 1)
                          : iio_device_attr_read(device, attribute, text.data(), text.size() - 1);
    if (size < 0) return std::nullopt;
    return std::string{text.data()};
}

std::optional<double> iio_number(const iio_device* device, const iio_channel* channel,
                                 const char* attribute) {
    const auto text = iio_text(device, channel, attribute);
    double value = 0;
    if (!text || std::from_chars(text->data(), text->data() + text->size(), value).ec != std::errc{})
        return std::nullopt;
    return value;
}

std::optional<std::string> iio_serial(const iio_device* device) {
    for (const char* attribute : {"serial_number", "serial"})
        if (auto text = iio_text(device, nullptr, attribute)) return text;
    return std::nullopt;
}

}  // namespace shaker
