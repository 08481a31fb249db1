#pragma once
// Text protocol of the IIO daemon (libiio 0.24): one line per command, one number per reply.
#include <cstdint>
#include <string>
#include <string_view>

namespace shaker::mock {

enum class IiodVerb {
    none,  // an empty line: no reply
    print,
    version,
    timeout,
    read,
    write,
    get_trigger,
    set_trigger,
    set_buffers,
    open,
    read_buffer,
    close,
    exit,
    refused,  // unknown verb, or missing words
};

/// Owner of the attribute of READ and WRITE.
enum class IiodOwner { device, channel, buffer, debug };

struct IiodCommand {
    IiodVerb verb = IiodVerb::none;
    std::string device;
    IiodOwner owner = IiodOwner::device;
    std::string channel;
    bool output = false;       // of the channel
    std::string attribute;     // empty: all of them
    std::string trigger;       // empty: none
    std::uint64_t number = 0;  // TIMEOUT: ms; WRITE, READBUF: bytes; OPEN: samples; SET: buffers
    std::string mask;          // as received; see decode_iiod_mask()
};

/// Parses one line without its end. Verbs in upper or lower case. ZPRINT and WRITEBUF are refused.
IiodCommand parse_iiod_command(std::string_view line);

/// Bit i is channel i. False unless the text is exactly eight hexadecimal digits (up to 32 channels).
bool decode_iiod_mask(std::string_view text, std::uint32_t& mask) noexcept;
std::string encode_iiod_mask(std::uint32_t mask);

}  // namespace shaker::mock
