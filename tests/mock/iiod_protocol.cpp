#include "tests/mock/iiod_protocol.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <utility>
#include <vector>

namespace shaker::mock {
namespace {

std::vector<std::string_view> words_of(std::string_view line) {
    constexpr std::string_view blanks = " \t\r\n";
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t begin = line.find_first_not_of(blanks);
        if (begin == std::string_view::npos) return words;
        line.remove_prefix(begin);
        const std::size_t length = std::min(line.find_first_of(blanks), line.size());
        words.push_back(line.substr(0, length));
        line.remove_prefix(length);
    }
}

std::string lower(std::string_view word) {
    std::string text{word};
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

IiodVerb verb_of(std::string_view word) {
    constexpr std::array<std::pair<std::string_view, IiodVerb>, 12> verbs{{
        {"print", IiodVerb::print},
        {"version", IiodVerb::version},
        {"timeout", IiodVerb::timeout},
        {"read", IiodVerb::read},
        {"write", IiodVerb::write},
        {"gettrig", IiodVerb::get_trigger},
        {"settrig", IiodVerb::set_trigger},
        {"set", IiodVerb::set_buffers},
        {"open", IiodVerb::open},
        {"readbuf", IiodVerb::read_buffer},
        {"close", IiodVerb::close},
        {"exit", IiodVerb::exit},
    }};
    const std::string name = lower(word);
    const auto* found = std::ranges::find(verbs, name, &std::pair<std::string_view, IiodVerb>::first);
    return found == verbs.end() ? IiodVerb::refused : found->second;
}

/// The words after the verb, one by one; a missing or malformed word makes the command invalid.
class Words {
public:
    explicit Words(std::vector<std::string_view> words) : words_{std::move(words)} {}
    [[nodiscard]] bool empty() const noexcept { return next_ >= words_.size(); }
    [[nodiscard]] std::string peek() const { return empty() ? std::string{} : lower(words_[next_]); }
    std::string text() {
        good_ = good_ && !empty();
        return good_ ? std::string{words_[next_++]} : std::string{};
    }
    std::string text_if_any() { return empty() ? std::string{} : text(); }
    std::uint64_t number() {
        const std::string digits = text();
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        good_ = good_ && error == std::errc{} && end == digits.data() + digits.size();
        return value;
    }
    [[nodiscard]] bool good() const noexcept { return good_; }
    void refuse() noexcept { good_ = false; }

private:
    std::vector<std::string_view> words_;
    std::size_t next_ = 0;
    bool good_ = true;
};

void parse_attribute(Words& words, IiodCommand& command) {
    command.device = words.text();
    const std::string owner = words.peek();
    if (owner == "buffer" || owner == "debug") {
        command.owner = owner == "buffer" ? IiodOwner::buffer : IiodOwner::debug;
        words.text();
    } else if (owner == "input" || owner == "output") {
        command.owner = IiodOwner::channel;
        command.output = owner == "output";
        words.text();
        command.channel = words.text();
    }
    if (command.verb == IiodVerb::read) {
        command.attribute = words.text_if_any();
    } else {
        command.attribute = words.text();
        command.number = words.number();
    }
}

void parse_open(Words& words, IiodCommand& command) {
    command.device = words.text();
    command.number = words.number();
    command.mask = words.text();
    if (words.peek() == "cyclic") words.text();  // for outputs; ignored for an input
}

void parse_arguments(Words& words, IiodCommand& command) {
    switch (command.verb) {
        case IiodVerb::timeout:
            command.number = words.number();
            break;
        case IiodVerb::read:
        case IiodVerb::write:
            parse_attribute(words, command);
            break;
        case IiodVerb::get_trigger:
        case IiodVerb::close:
            command.device = words.text();
            break;
        case IiodVerb::set_trigger:
            command.device = words.text();
            command.trigger = words.text_if_any();
            break;
        case IiodVerb::set_buffers:
            command.device = words.text();
            if (lower(words.text()) != "buffers_count") words.refuse();
            command.number = words.number();
            break;
        case IiodVerb::open:
            parse_open(words, command);
            break;
        case IiodVerb::read_buffer:
            command.device = words.text();
            command.number = words.number();
            break;
        default:
            break;
    }
    if (!words.good() || !words.empty()) command.verb = IiodVerb::refused;
}

}  // namespace

IiodCommand parse_iiod_command(std::string_view line) {
    std::vector<std::string_view> words = words_of(line);
    IiodCommand command;
    if (words.empty()) return command;
    command.verb = verb_of(words.front());
    words.erase(words.begin());
    Words arguments{std::move(words)};
    if (command.verb != IiodVerb::refused) parse_arguments(arguments, command);
    return command;
}

bool decode_iiod_mask(std::string_view text, std::uint32_t& mask) noexcept {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, mask, 16);
    return text.size() == 8 && error == std::errc{} && stop == end;
}

std::string encode_iiod_mask(std::uint32_t mask) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", mask);
    return text.data();
}

}  // namespace shaker::mock
