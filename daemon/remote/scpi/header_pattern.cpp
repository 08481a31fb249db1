#include "daemon/remote/scpi/header_pattern.hpp"

#include <charconv>
#include <utility>

#include "drivers/errors.hpp"

namespace shaker::scpi {
namespace {

class Reader {
public:
    explicit Reader(const std::string& header) : header_{header}, rest_{header} {}

    HeaderPattern read() {
        HeaderPattern pattern;
        while (!rest_.empty()) {
            const bool colon_due = !pattern.empty() && !pattern.back().before;
            const bool optional = skip('[');
            if (skip(':') != colon_due) refuse("has too many or too few colons");
            pattern.push_back(node());
            pattern.back().optional = optional;
            if (!optional) continue;
            pattern.back().before = skip(':');
            if (pattern.back().before == colon_due) refuse("requires one colon inside its brackets");
            if (!skip(']')) refuse("has an unclosed bracket");
        }
        if (!pattern.empty() && pattern.back().before) refuse("ends in a colon");
        if (pattern.empty()) refuse("is empty");
        return pattern;
    }

private:
    [[noreturn]] void refuse(const std::string& why) const {
        throw InputError{"command header \"" + header_ + "\" " + why};
    }
    bool skip(char c) {
        if (!rest_.starts_with(c)) return false;
        rest_.remove_prefix(1);
        return true;
    }
    HeaderNode node() {
        std::size_t length = rest_.starts_with('*') ? 1 : 0;
        while (length < rest_.size() && (is_letter(rest_[length]) || rest_[length] == '_')) ++length;
        const std::string written{rest_.substr(0, length)};
        rest_.remove_prefix(length);
        if (written.empty() || length > longest_mnemonic) refuse("requires mnemonics of 1 to 12 letters");
        HeaderNode node{.keyword = Keyword{written}, .written = written};
        if (node.keyword.short_form.empty()) refuse("requires capitals for the short form");
        if (skip('<')) {
            node.slot = slots_++;
            node.first = bound();
            if (!skip('.') || !skip('.')) refuse("requires numbers written as <1..16>");
            node.last = bound();
            if (!skip('>') || node.last < node.first) refuse("requires numbers written as <1..16>");
        }
        return node;
    }
    std::uint16_t bound() {
        std::uint16_t value = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
        if (error != std::errc{}) refuse("requires numbers written as <1..16>");
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return value;
    }

    const std::string& header_;
    std::string_view rest_;
    int slots_ = 0;
};

}  // namespace

HeaderPattern read_pattern(const std::string& header) { return Reader{header}.read(); }

}  // namespace shaker::scpi
