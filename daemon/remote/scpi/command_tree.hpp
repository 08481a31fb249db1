#pragma once
// CommandTree: finds commands by their headers, at a cost independent of their number.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

/// A part of a header of the table of commands: "[SOURce:]" or "HARMonic<1..16>".
struct HeaderNode {
    Keyword keyword;
    std::string written;  // "HARMonic"
    bool optional = false;
    bool before = false;  // optional and written "[SOURce:]": shown in messages; "[:STATe]" is not
    int slot = -1;        // index of the number after it in the header; -1: none
    std::uint16_t first = 1, last = 1;  // range of that number
};

using HeaderPattern = std::vector<HeaderNode>;

/// Throws InputError with the header if it is not in the notation of Command.
HeaderPattern read_pattern(const std::string& header);

inline constexpr std::size_t deepest = 8;  // mnemonics in a header

/// Position in the tree after the last header; the next header of the same message starts there.
struct Path {
    std::uint32_t node = 0;
    std::uint32_t depth = 0;
    std::array<std::uint16_t, deepest> numbers{};  // after the mnemonics so far; no_number: none
};
inline constexpr std::uint16_t no_number = 0xffff;

/// A recognised header.
struct Found {
    const Command* command = nullptr;
    const HeaderPattern* pattern = nullptr;
    bool query = false;
    std::array<std::uint16_t, deepest> suffixes{};
    std::size_t suffix_count = 0;

    /// "SOURce:HARMonic3:AMPLitude", for messages.
    [[nodiscard]] std::string name() const;
};

/// Immutable after construction; shared by all sessions.
class CommandTree {
public:
    /// Throws InputError for an invalid pattern and for two rows with the same header.
    explicit CommandTree(std::vector<Command> commands);
    CommandTree(const CommandTree&) = delete;
    CommandTree& operator=(const CommandTree&) = delete;

    /// Reads the header at the start of `text`, including its ?, and moves `path`. Does not allocate. Throws
    /// Error -101 -102 -103 -112 -113 -114.
    Found find(Text& text, Path& path) const;

    [[nodiscard]] std::span<const Command> commands() const noexcept { return commands_; }

private:
    static constexpr std::uint32_t none = 0xffffffff;
    struct Edge {
        Mnemonic word;
        std::uint32_t from = none;  // none: this slot of the table is free
        std::uint32_t to = 0;
    };
    /// The command at a node, and the levels above that have its numbers.
    struct Leaf {
        std::uint32_t command = none;
        /// For each level: index of <...> in the header; -1: no number allowed.
        std::array<int, deepest> slots{};
    };

    void add(std::uint32_t command, std::size_t i, std::uint32_t node, std::size_t level, Leaf leaf);
    std::uint32_t child(std::uint32_t from, const HeaderNode& node);
    void connect(std::uint32_t from, const Mnemonic& word, std::uint32_t to);
    [[nodiscard]] std::uint32_t follow(std::uint32_t from, const Mnemonic& word) const noexcept;
    [[nodiscard]] std::size_t place(std::uint32_t from, const Mnemonic& word) const noexcept;
    [[nodiscard]] Found at_leaf(const Path& path, bool query) const;

    std::vector<Command> commands_;
    std::vector<HeaderPattern> patterns_;
    std::vector<Leaf> leaves_;
    std::vector<Edge> edges_;  // a hash table of a power of two, at most half full
    std::size_t edge_count_ = 0;
};

}  // namespace shaker::scpi
