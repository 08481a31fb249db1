#include "tests/mock/iiod_device.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <utility>

#include "drivers/errors.hpp"
#include "drivers/quantity.hpp"

namespace shaker::mock {
namespace {

constexpr std::array<std::string_view, 3> axes{"accel_x", "accel_y", "accel_z"};
constexpr std::string_view stamp_channel = "timestamp";
constexpr std::size_t stamp_bytes = 8;

constexpr std::string_view document_type = R"(<!DOCTYPE context [
<!ELEMENT context (device | context-attribute)*>
<!ELEMENT context-attribute EMPTY>
<!ELEMENT device (channel | attribute | debug-attribute | buffer-attribute)*>
<!ELEMENT channel (scan-element?, attribute*)>
<!ELEMENT scan-element EMPTY>
<!ELEMENT attribute EMPTY>
<!ELEMENT debug-attribute EMPTY>
<!ELEMENT buffer-attribute EMPTY>
<!ATTLIST context name CDATA #REQUIRED description CDATA #IMPLIED
          version-major CDATA #IMPLIED version-minor CDATA #IMPLIED version-git CDATA #IMPLIED>
<!ATTLIST context-attribute name CDATA #REQUIRED value CDATA #REQUIRED>
<!ATTLIST device id CDATA #REQUIRED name CDATA #IMPLIED label CDATA #IMPLIED>
<!ATTLIST channel id CDATA #REQUIRED type (input | output) #REQUIRED name CDATA #IMPLIED>
<!ATTLIST scan-element index CDATA #REQUIRED format CDATA #REQUIRED scale CDATA #IMPLIED>
<!ATTLIST attribute name CDATA #REQUIRED filename CDATA #IMPLIED>
<!ATTLIST debug-attribute name CDATA #REQUIRED>
<!ATTLIST buffer-attribute name CDATA #REQUIRED>
]>)";

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    return out;
}

std::string attribute(std::string_view name, std::string_view file = {}) {
    std::string xml = "<attribute name=\"" + std::string{name} + "\"";
    if (!file.empty()) xml += " filename=\"" + std::string{file} + "\"";
    return xml + " />";
}

template <class Unsigned>
void append_big_endian(Unsigned value, std::vector<char>& out) {
    for (std::size_t byte = sizeof(Unsigned); byte-- > 0;)
        out.push_back(static_cast<char>((value >> (8 * byte)) & 0xff));
}

}  // namespace

IiodDevice::IiodDevice(IiodDescription description) : d_{std::move(description)} {
    if (d_.bits < 1 || d_.bits > 32)
        throw InputError{"mock iiod: " + std::to_string(d_.bits) +
                         " bits are not supported: must be 1 to 32"};
}

std::string IiodDevice::xml() const {
    const std::size_t storage = 8 * storage_bytes();
    const std::string format = "be:s" + std::to_string(d_.bits) + "/" + std::to_string(storage) + ">>" +
                               std::to_string(storage - static_cast<std::size_t>(d_.bits));
    std::string xml = "<?xml version=\"1.0\" encoding=\"utf-8\"?>" + std::string{document_type};
    xml += R"(<context name="mock" description="accelerometer without hardware" version-major="0" )"
           R"(version-minor="24" version-git="mockiio">)";
    xml += "<device id=\"" + std::string{id} + "\" name=\"" + escaped(d_.name) + "\"";
    if (!d_.label.empty()) xml += " label=\"" + escaped(d_.label) + "\"";
    xml += ">";
    for (std::size_t i = 0; i < axes.size(); ++i) {
        const std::string prefix = "in_" + std::string{axes[i]} + "_";
        xml += "<channel id=\"" + std::string{axes[i]} + "\" type=\"input\"><scan-element index=\"" +
               std::to_string(i) + "\" format=\"" + format + "\" scale=\"" + to_text(d_.mps2_per_count[i]) +
               "\" />" + attribute("offset", prefix + "offset") + attribute("scale", prefix + "scale") +
               attribute("sampling_frequency", "in_accel_sampling_frequency") +
               attribute("sampling_frequency_available", "in_accel_sampling_frequency_available") +
               "</channel>";
    }
    xml +=
        "<channel id=\"timestamp\" type=\"input\">"
        "<scan-element index=\"3\" format=\"le:s64/64>>0\" /></channel>";
    xml += attribute("current_timestamp_clock");
    if (!d_.serial.empty()) xml += attribute("serial_number");
    xml += "<buffer-attribute name=\"length_align_bytes\" /></device>";
    return xml + "<device id=\"" + std::string{trigger_id} + "\" name=\"" + escaped(trigger_name()) +
           "\" /></context>";
}

bool IiodDevice::is_device(std::string_view who) const noexcept {
    return who == id || who == d_.name || (!d_.label.empty() && who == d_.label);
}

bool IiodDevice::is_trigger(std::string_view who) const noexcept {
    return who == trigger_id || who == trigger_name();
}

int IiodDevice::axis(const IiodCommand& command) const noexcept {
    const auto* found = std::ranges::find(axes, command.channel);
    if (command.output || found == axes.end()) return -1;
    return static_cast<int>(found - axes.begin());
}

int IiodDevice::read(const IiodCommand& command, std::string& value) const {
    if (!is_device(command.device)) return is_trigger(command.device) ? -ENOENT : -ENODEV;
    const std::string& name = command.attribute;
    if (name.empty()) return -EINVAL;  // all attributes at once: not used by libiio's programs
    if (command.owner == IiodOwner::channel) {
        const int k = axis(command);
        if (k < 0) return command.channel == stamp_channel && !command.output ? -ENOENT : -ENXIO;
        const auto i = static_cast<std::size_t>(k);
        if (name == "scale") return value = to_text(d_.mps2_per_count[i]), 0;
        if (name == "offset") return value = to_text(d_.offset_counts[i]), 0;
        if (name == "sampling_frequency") return value = to_text(d_.rate_hz), 0;
        if (name != "sampling_frequency_available") return -ENOENT;
        for (const double rate : d_.rates_hz) value += (value.empty() ? "" : " ") + to_text(rate);
        return 0;
    }
    if (command.owner == IiodOwner::device && name == "current_timestamp_clock") return value = clock_, 0;
    if (command.owner == IiodOwner::device && name == "serial_number" && !d_.serial.empty())
        return value = d_.serial, 0;
    if (command.owner == IiodOwner::buffer && name == "length_align_bytes") return value = "8", 0;
    return -ENOENT;
}

int IiodDevice::write(const IiodCommand& command, std::string_view value) {
    while (!value.empty() && (value.back() == '\0' || value.back() == '\n')) value.remove_suffix(1);
    std::string old;
    if (const int rc = read(command, old); rc < 0) return rc;
    if (command.owner == IiodOwner::device && command.attribute == "current_timestamp_clock") {
        if (value != "realtime" && !(value == "monotonic" && d_.monotonic)) return -EINVAL;
        clock_ = value;
        return 0;
    }
    if (command.owner != IiodOwner::channel || command.attribute != "sampling_frequency") return -EACCES;
    double rate = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), rate);
    if (error != std::errc{} || end != value.data() + value.size()) return -EINVAL;
    if (std::ranges::find(d_.rates_hz, rate) == d_.rates_hz.end()) return -EINVAL;
    d_.rate_hz = rate;
    return 0;
}

std::size_t IiodDevice::sample_size(std::uint32_t mask) const noexcept {
    std::size_t size = 0;
    for (unsigned i = 0; i < axes.size(); ++i)
        if ((mask >> i & 1) != 0) size += storage_bytes();
    if ((mask >> axes.size() & 1) == 0) return size;
    return (size + stamp_bytes - 1) / stamp_bytes * stamp_bytes + stamp_bytes;
}

void IiodDevice::encode(const IiodSample& sample, std::uint32_t mask, std::vector<char>& out) const {
    const std::size_t begin = out.size(), unused = 8 * storage_bytes() - static_cast<std::size_t>(d_.bits);
    const std::uint32_t ones = (std::uint32_t{1} << unused) - 1;
    for (unsigned i = 0; i < axes.size(); ++i) {
        if ((mask >> i & 1) == 0) continue;
        const std::uint32_t word = (static_cast<std::uint32_t>(sample.counts[i]) << unused) | ones;
        if (storage_bytes() == 2)
            append_big_endian(static_cast<std::uint16_t>(word), out);
        else
            append_big_endian(word, out);
    }
    if ((mask >> axes.size() & 1) == 0) return;
    out.resize(begin + sample_size(mask) - stamp_bytes);
    auto stamp = static_cast<std::uint64_t>(sample.stamp_ns);
    for (std::size_t byte = 0; byte < stamp_bytes; ++byte, stamp >>= 8)
        out.push_back(static_cast<char>(stamp & 0xff));
}

}  // namespace shaker::mock
