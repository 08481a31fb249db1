#include "daemon/remote/scpi/command_tree.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "daemon/remote/scpi/error.hpp"
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

/// The whole unknown header, for the message; colons and question marks included.
std::string header_at(const char* from, const Text& text) {
    const char* end = from;
    while (end != text.end && (is_word(*end) || *end == ':' || *end == '*' || *end == '?')) ++end;
    return printable({from, static_cast<std::size_t>(end - from)});
}

[[noreturn]] void refuse_character(const Text& text, const char* from) {
    const std::string_view raw{from, static_cast<std::size_t>(text.at - from) + (text.empty() ? 0U : 1U)};
    constexpr std::string_view plain = "*?:;,.+-/()'\"#<>";
    if (text.peek() == ',') throw Error{Code::invalid_separator, printable(raw)};
    const bool syntax =
        is_blank(text.peek()) || is_digit(text.peek()) || plain.find(text.peek()) != std::string_view::npos;
    throw Error{syntax ? Code::syntax : Code::invalid_character, printable(raw)};
}

/// A mnemonic and the number after it.
struct Word {
    Mnemonic mnemonic;
    std::uint16_t number = no_number;
};

Word read_mnemonic(Text& text, const char* header) {
    const char* const from = text.at;
    if (text.peek() == '*') ++text.at;
    if (!is_letter(text.peek())) refuse_character(text, header);
    while (is_word(text.peek())) ++text.at;
    const char* end = text.at;
    while (is_digit(end[-1])) --end;
    const auto length = static_cast<std::size_t>(end - from);
    if (length > longest_mnemonic)
        throw Error{Code::mnemonic_too_long, printable({from, length}) + ", allowed 12 characters"};
    Word word{.mnemonic = mnemonic({from, length})};
    if (end == text.at) return word;
    unsigned number = 0;
    for (; end != text.at; ++end)
        number = std::min(10 * number + static_cast<unsigned>(*end - '0'), unsigned{no_number} - 1);
    word.number = static_cast<std::uint16_t>(number);
    return word;
}

}  // namespace

HeaderPattern read_pattern(const std::string& header) { return Reader{header}.read(); }

std::string Found::name() const {
    std::string name;
    for (const HeaderNode& node : *pattern) {
        if (node.optional && !node.before) continue;
        if (!name.empty()) name += ':';
        name += node.written;
        if (node.slot >= 0) name += std::to_string(suffixes.at(static_cast<std::size_t>(node.slot)));
    }
    return query ? name + "?" : name;
}

CommandTree::CommandTree(std::vector<Command> commands)
    : commands_{std::move(commands)}, leaves_(1), edges_(64) {
    for (const Command& command : commands_) patterns_.push_back(read_pattern(command.header));
    Leaf none_yet;
    none_yet.slots.fill(-1);
    for (std::uint32_t i = 0; i < commands_.size(); ++i) {
        const std::size_t most =
            std::max(commands_[i].parameters.size(), commands_[i].query_parameters.size());
        if (most > most_parameters)
            throw InputError{commands_[i].header + ": " + std::to_string(most) +
                             " parameters, allowed at most " + std::to_string(most_parameters)};
        add(i, 0, 0, 0, none_yet);
    }
}

void CommandTree::add(std::uint32_t command, std::size_t i, std::uint32_t node, std::size_t level,
                      Leaf leaf) {
    const HeaderPattern& pattern = patterns_[command];
    if (i == pattern.size()) {
        leaf.command = command;
        if (level == 0) throw InputError{commands_[command].header + ": all of it is optional"};
        if (leaves_[node].command != none)
            throw InputError{commands_[command].header + " is the same header as " +
                             commands_[leaves_[node].command].header};
        leaves_[node] = leaf;
        return;
    }
    if (pattern[i].optional) add(command, i + 1, node, level, leaf);
    if (level == deepest) throw InputError{commands_[command].header + ": more than 8 mnemonics"};
    leaf.slots[level] = pattern[i].slot;
    add(command, i + 1, child(node, pattern[i]), level + 1, leaf);
}

std::uint32_t CommandTree::child(std::uint32_t from, const HeaderNode& node) {
    const std::uint32_t brief = follow(from, node.keyword.brief), full = follow(from, node.keyword.full);
    if (brief != full)
        throw InputError{node.written + ": its short or long form is a form of another mnemonic"};
    if (brief != none) return brief;
    const auto to = static_cast<std::uint32_t>(leaves_.size());
    leaves_.emplace_back();
    connect(from, node.keyword.brief, to);
    if (node.keyword.full != node.keyword.brief) connect(from, node.keyword.full, to);
    return to;
}

void CommandTree::connect(std::uint32_t from, const Mnemonic& word, std::uint32_t to) {
    if (2 * (edge_count_ + 1) > edges_.size()) {
        const std::vector<Edge> old = std::exchange(edges_, std::vector<Edge>(2 * edges_.size()));
        for (const Edge& edge : old)
            if (edge.from != none) edges_[place(edge.from, edge.word)] = edge;
    }
    edges_[place(from, word)] = {word, from, to};
    ++edge_count_;
}

std::uint32_t CommandTree::follow(std::uint32_t from, const Mnemonic& word) const noexcept {
    const Edge& edge = edges_[place(from, word)];
    return edge.from == none ? none : edge.to;
}

std::size_t CommandTree::place(std::uint32_t from, const Mnemonic& word) const noexcept {
    const std::uint64_t low = word.tail | (std::uint64_t{from} << 32U);
    std::uint64_t hash = (word.head ^ (low * 0x9e3779b97f4a7c15U)) * 0xd6e8feb86659fd93U;
    hash ^= hash >> 32U;
    const std::size_t mask = edges_.size() - 1;
    std::size_t i = hash & mask;
    while (edges_[i].from != none && !(edges_[i].from == from && edges_[i].word == word)) i = (i + 1) & mask;
    return i;
}

Found CommandTree::find(Text& text, Path& path) const {
    const char* const from = text.at;
    const bool common = text.peek() == '*', root = text.peek() == ':';
    Path here = common || root ? Path{} : path, parent;
    if (root) ++text.at;
    bool known = true;
    for (;;) {
        parent = here;
        const Word word = read_mnemonic(text, from);
        const bool fits = known && here.depth < deepest;
        const std::uint32_t next = fits ? follow(here.node, word.mnemonic) : none;
        known = next != none;
        if (known) {
            here.node = next;
            here.numbers[here.depth++] = word.number;
        }
        if (common || text.peek() != ':') break;
        ++text.at;
    }
    const bool query = text.peek() == '?';
    if (query) ++text.at;
    if (!known || leaves_[here.node].command == none)
        throw Error{Code::undefined_header, header_at(from, text)};
    const Found found = at_leaf(here, query);
    if (!(query ? found.command->query : found.command->set))
        throw Error{Code::undefined_header,
                    header_at(from, text) + (query ? ", there is no query" : ", there is only a query")};
    if (!is_blank(text.peek()) && text.peek() != ';') refuse_character(text, from);
    if (!common) path = parent;
    return found;
}

Found CommandTree::at_leaf(const Path& path, bool query) const {
    const Leaf& leaf = leaves_[path.node];
    Found found{.command = &commands_[leaf.command], .pattern = &patterns_[leaf.command], .query = query};
    found.suffixes.fill(1);
    for (const HeaderNode& node : *found.pattern) found.suffix_count += node.slot >= 0 ? 1U : 0U;
    for (std::size_t level = 0; level < path.depth; ++level) {
        const std::uint16_t number = path.numbers[level];
        if (number == no_number) continue;
        if (leaf.slots[level] < 0)
            throw Error{Code::header_suffix_out_of_range,
                        std::to_string(number) + " in " + found.name() + ", no number is allowed there"};
        found.suffixes[static_cast<std::size_t>(leaf.slots[level])] = number;
    }
    for (const HeaderNode& node : *found.pattern) {
        if (node.slot < 0) continue;
        const std::uint16_t number = found.suffixes[static_cast<std::size_t>(node.slot)];
        if (number < node.first || number > node.last)
            throw Error{Code::header_suffix_out_of_range, found.name() + ", allowed " + node.written +
                                                              std::to_string(node.first) + " to " +
                                                              std::to_string(node.last)};
    }
    return found;
}

}  // namespace shaker::scpi
