#include "drivers/hardware/iio/context.hpp"

#include <iio.h>
#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>

#include "drivers/errors.hpp"

namespace shaker::iio {

namespace {
constexpr const char* rate_attribute = "sampling_frequency";
}

void IioContextEnd::operator()(iio_context* context) const noexcept { iio_context_destroy(context); }

std::string iio_words(int rc) {
    std::array<char, 256> words{};
    iio_strerror(rc < 0 ? -rc : rc, words.data(), words.size());
    return words.data();
}

namespace {

/// For a name that it cannot resolve, libiio prints lines of its own and returns the error of another cause.
void require_known_host(const std::string& uri) {
    constexpr std::string_view network{"ip:"};
    if (!uri.starts_with(network)) return;
    std::string host = uri.substr(network.size());
    if (host.empty()) throw DeviceError{uri + ": a host is missing; expected ip:host or ip:host:port"};
    if (std::ranges::count(host, ':') == 1) host.erase(host.find(':'));
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(host.c_str(), nullptr, nullptr, &found);
    if (error == 0) return ::freeaddrinfo(found);
    const bool local = host.ends_with(".local");
    if (local && std::filesystem::exists("/run/avahi-daemon/socket")) return;  // libiio asks it
    throw DeviceError{
        uri + ": the name " + host + " is not known on this computer (" + ::gai_strerror(error) + ")" +
        (local ? "; names in .local need mDNS (package libnss-mdns)" : "") + "; give the address instead"};
}

}  // namespace

IioContextHandle open_iio_context(const std::string& uri) {
    require_known_host(uri);
    // libiio writes to sockets without MSG_NOSIGNAL: a closed connection would end the process.
    if (struct sigaction action{}; sigaction(SIGPIPE, nullptr, &action) == 0 && action.sa_handler == SIG_DFL)
        std::signal(SIGPIPE, SIG_IGN);
    std::string scratch = uri;  // libiio 0.24 writes a NUL over the colon before a port
    IioContextHandle context{iio_create_context_from_uri(scratch.data())};
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

IioRate iio_rate(const iio_device* device, const iio_channel* channel) {
    if (iio_device_find_attr(device, rate_attribute) != nullptr) return {device, nullptr};
    if (iio_channel_find_attr(channel, rate_attribute) != nullptr) return {device, channel};
    const iio_device* trigger = iio_trigger(device);
    if (trigger != nullptr && iio_device_find_attr(trigger, rate_attribute) != nullptr)
        return {trigger, nullptr};
    return {};
}

std::optional<std::string> IioRate::text() const {
    return exists() ? iio_text(device, channel, rate_attribute) : std::nullopt;
}

std::optional<std::string> IioRate::choice() const {
    return exists() ? iio_text(device, channel, "sampling_frequency_available") : std::nullopt;
}

std::optional<double> IioRate::hz() const {
    return exists() ? iio_number(device, channel, rate_attribute) : std::nullopt;
}

long IioRate::set(const std::string& hz) const {
    return channel != nullptr ? iio_channel_attr_write(channel, rate_attribute, hz.c_str())
                              : iio_device_attr_write(device, rate_attribute, hz.c_str());
}

const iio_device* iio_trigger(const iio_device* device) {
    const iio_device* trigger = nullptr;
    return iio_device_get_trigger(device, &trigger) == 0 ? trigger : nullptr;
}

std::string iio_string(const char* text) { return text == nullptr ? std::string{} : std::string{text}; }

std::optional<std::string> iio_serial(const iio_device* device) {
    for (const char* attribute : {"serial_number", "serial"})
        if (auto text = iio_text(device, nullptr, attribute)) return text;
    return std::nullopt;
}

}  // namespace shaker::iio
