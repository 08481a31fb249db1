#pragma once
// The words of the IIO daemon's text protocol (libiio 0.24): one line a command, one number a reply.
#include <cstdint>
#include <string>
#include <string_view>

namespace shaker {

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
    refused,  // anything else, or words missing
};

/// Whose attribute READ and WRITE mean.
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
    std::string mask;          // as it came; decode_iiod_mask() reads it
};

/// One line without its end. Verbs in upper or lower case; ZPRINT and WRITEBUF are refused.
IiodCommand parse_iiod_command(std::string_view line);

/// Bit i is channel i. Returns false unless the text is exactly eight hexadecimal digits, which is what up to
/// 32 channels take.
bool decode_iiod_mask(std::string_view text, std::uint32_t& mask) noexcept;
std::string encode_iiod_mask(std::uint32_t mask);

}  // namespace shaker
