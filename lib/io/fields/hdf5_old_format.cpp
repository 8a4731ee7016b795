#include "io/fields/hdf5.hpp"
#include "io/meshes/raw_values.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

// "HDF5 File Format Specification", version 3.0, of The HDF Group: level 0 A (superblock), III A 1 and 2 (B-trees of
// version 1, symbol tables), III D (local heaps), IV A (object headers of version 1 and their messages).

namespace clsdf::hdf5 {
namespace {

/// The address of an absent object.
constexpr std::uint64_t nowhere = ~std::uint64_t{0};

/// Reads bytes of an HDF5 file's structure, one after the other. Throws Error(unreadable_input) at their end.
class Bytes {
public:
    /// From an address of the file on. `what` describes the bytes in messages.
    Bytes(InputFile& file, std::uint64_t address, std::uint64_t size, const char* what);
    /// Bytes that have been read already, which must outlive this.
    Bytes(InputFile& file, std::string_view bytes, const char* what) : file_(file), rest_(bytes), what_(what) {}
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;

    std::size_t left() const { return rest_.size(); }
    std::string_view take(std::uint64_t count);
    void skip(std::uint64_t count) { take(count); }
    /// A whole number of up to 8 bytes, the lowest first.
    std::uint64_t number(std::size_t width);
    /// Takes the letters that a part of the structure begins with.
    void expect(std::string_view signature);
    void expect(std::uint64_t number, std::size_t width, const char* name);

    [[noreturn]] void fail(const std::string& reason) const;

private:
    InputFile& file_;
    std::string content_;
    std::string_view rest_;
    const char* what_;
};

// The parts of the structure that a field needs are smaller.
constexpr std::uint64_t largest_part = std::uint64_t{1} << 22;

Bytes::Bytes(InputFile& file, std::uint64_t address, std::uint64_t size, const char* what) : file_(file), what_(what) {
    if (address > file.size() || size > file.size() - address)
        fail(fmt::format("{} bytes from byte {} on do not lie in the {} bytes of the file; it is truncated or damaged",
                         size, address, file.size()));
    if (size > largest_part) fail(fmt::format("{} bytes are more than any field has", size));
    content_.resize(static_cast<std::size_t>(size));
    file.read(address, std::as_writable_bytes(std::span(content_)));
    rest_ = content_;
}

std::string_view Bytes::take(std::uint64_t count) {
    if (count > rest_.size()) fail("it ends early; the file is damaged");
    const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
    rest_.remove_prefix(taken.size());
    return taken;
}

std::uint64_t Bytes::number(std::size_t width) {
    const std::string_view bytes = take(width);
    std::uint64_t value = 0;
    for (std::size_t i = width; i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[i]);
    return value;
}

void Bytes::expect(std::string_view signature) {
    if (take(signature.size()) != signature)
        fail(fmt::format("it does not begin with '{}'; the file is damaged", signature));
}

void Bytes::expect(std::uint64_t number, std::size_t width, const char* name) {
    if (const std::uint64_t found = this->number(width); found != number)
        fail(fmt::format("its {} is {}, not {}; save the field with HDF5's default settings", name, found, number));
}

void Bytes::fail(const std::string& reason) const {
    file_.fail(fmt::format("HDF5: {}: {}", what_, reason));
}

// A damaged file may contain cycles.
constexpr std::size_t most_nodes = 10000;
constexpr std::uint64_t most_members = 100000;
constexpr std::uint64_t largest_header = std::uint64_t{1} << 22;

enum MessageType : std::uint64_t {
    dataspace = 0x01,
    datatype = 0x03,
    external_files = 0x07,
    layout = 0x08,
    filters = 0x0B,
    attribute = 0x0C,
    continuation = 0x10,
    symbol_table = 0x11,
};

struct Message {
    std::uint64_t type;
    bool is_elsewhere;  // shared with other objects
    std::string content;
};

struct NumberType {
    bool is_real;
    bool is_signed;
    std::size_t width;
    std::endian order;
};

/// Absent if the type is no machine number.
std::optional<NumberType> number_type(Bytes message) {
    const std::uint64_t type_class = message.number(1) & 15U;
    const std::uint64_t bits = message.number(3);
    const auto width = static_cast<std::size_t>(message.number(4));
    if ((width != 1 && width != 2 && width != 4 && width != 8) || type_class > 1) return std::nullopt;
    const std::endian order = (bits & 1U) != 0 ? std::endian::big : std::endian::little;
    if (message.number(2) != 0 || message.number(2) != 8 * width) return std::nullopt;
    if (type_class == 0) {
        if ((bits & ~std::uint64_t{9}) != 0) return std::nullopt;
        return NumberType{false, (bits & 8U) != 0, width, order};
    }
    // IEEE 754: an implied leading one, the sign, then position and size of exponent and mantissa, the bias.
    const bool wide = width == 8;
    if (width < 4 || (bits & ~std::uint64_t{1}) != (wide ? 0x3F20U : 0x1F20U) ||
        message.number(1) != (wide ? 52 : 23) || message.number(1) != (wide ? 11 : 8) || message.number(1) != 0 ||
        message.number(1) != (wide ? 52 : 23) || message.number(4) != (wide ? 1023 : 127))
        return std::nullopt;
    return NumberType{true, true, width, order};
}

std::vector<std::uint64_t> dataspace_shape(Bytes message) {
    const std::uint64_t version = message.number(1);
    if (version != 1 && version != 2) message.fail(fmt::format("version {} is not known", version));
    const std::uint64_t dimensions = message.number(1);
    message.skip(version == 1 ? 6 : 2);
    std::vector<std::uint64_t> shape;
    for (std::uint64_t i = 0; i < dimensions; ++i) shape.push_back(message.number(8));
    return shape;
}

double number_of(std::string_view stored, const NumberType& type) {
    std::string bytes(stored);
    if (type.order != std::endian::little) std::ranges::reverse(bytes);
    std::uint64_t bits = 0;
    for (std::size_t i = type.width; i-- > 0;) bits = bits << 8U | static_cast<unsigned char>(bytes[i]);
    if (type.is_real) {
        if (type.width == 8) return std::bit_cast<double>(bits);
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    if (!type.is_signed) return static_cast<double>(bits);
    const auto unused = static_cast<unsigned>(64 - 8 * type.width);
    return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
}

/// Name, type, shape and value of an attribute.
struct Attribute {
    std::string name;
    std::string type;
    std::string shape;
    std::string value;
};

class OldFormat : public Source {
public:
    explicit OldFormat(InputFile& file) : file_(file) {
        Bytes block(file, 8, 88, "superblock");
        const std::uint64_t version = block.number(1);
        block.skip(4);
        block.expect(8, 1, "size of offsets");
        block.expect(8, 1, "size of lengths");
        block.skip(version == 0 ? 9 : 13);
        block.expect(0, 8, "base address");
        block.skip(8);
        if (block.number(8) > file.size()) file.fail("HDF5: the file is truncated");
        block.skip(16);
        root_ = messages_of(block.number(8));
        members_ = members_of(root_, "the root");
    }

    bool has(const std::string& path) const override { return address_of(path).has_value(); }

    StoredArray array(const WantedArray& wanted) const override {
        const std::vector<Message> messages = messages_of(wanted.name);
        StoredArray array;
        array.shape = shape_of(messages, wanted);
        set_type(array, messages, wanted);
        if (find(messages, external_files) != nullptr)
            fail(wanted.name, "its values are in another file; save them in this");
        if (find(messages, filters) != nullptr)
            fail(wanted.name, "its values are compressed; save them without filters");
        Bytes message(file_, require(messages, layout, wanted.name).content, "layout");
        message.expect(3, 1, "version");
        const std::uint64_t layout_class = message.number(1);
        if (layout_class == 1) {
            array.values.offset = message.number(8);
            array.values.bytes = message.number(8);
            if (array.values.offset == nowhere) fail(wanted.name, "it has no values");
        } else if (layout_class == 2) {
            set_chunks(array, message, wanted.name);
        } else {
            fail(wanted.name, "its values are neither contiguous nor in chunks; save it contiguous");
        }
        return array;
    }

    std::vector<double> numbers(const std::string& object, const std::string& name, std::size_t count,
                                const char* what) const override {
        const std::optional<Attribute> found = find_attribute(messages_of(object), name);
        if (!found) fail(object, fmt::format("attribute '{}' is missing; state {}", name, what));
        const auto type = number_type({file_, found->type, "type of an attribute"});
        if (!type || count_of(*found) != count || found->value.size() < count * type->width)
            fail(object, fmt::format("attribute '{}' is not {}", name, what));
        std::vector<double> result(count);
        for (std::size_t i = 0; i < count; ++i)
            result[i] = number_of(std::string_view(found->value).substr(i * type->width, type->width), *type);
        return result;
    }

    std::optional<std::string> text(const std::string& group, const std::string& name) const override {
        const std::optional<Attribute> found = find_attribute(group.empty() ? root_ : messages_of(group), name);
        if (!found) return std::nullopt;
        Bytes type(file_, found->type, "type of an attribute");
        constexpr std::uint64_t text_class = 3;
        const bool is_text = (type.number(1) & 15U) == text_class;
        type.skip(3);
        const std::uint64_t size = type.number(4);
        if (!is_text || count_of(*found) != 1 || size > found->value.size())
            file_.fail(fmt::format("attribute '{}' is not one text of fixed length", name));
        return found->value.substr(0, std::min(static_cast<std::size_t>(size), found->value.find('\0')));
    }

private:
    struct Block {
        std::uint64_t address;
        std::uint64_t size;
    };

    std::vector<Message> messages_of(std::uint64_t address) const {
        Bytes header(file_, address, 16, "object header");
        if (Bytes(file_, address, 4, "object header").take(4) == "OHDR")
            header.fail("an object of HDF5's newer format in a file of the older; save it with libver=\"latest\"");
        header.expect(1, 1, "version");
        header.skip(1);
        const std::uint64_t count = header.number(2);
        header.skip(4);
        std::vector<Block> blocks{{address + 16, header.number(4)}};
        std::vector<Message> messages;
        std::uint64_t size_so_far = 0;
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            size_so_far += std::max<std::uint64_t>(blocks[i].size, 256);
            if (blocks[i].size > largest_header || size_so_far > largest_header)
                header.fail("it is too large; the file is damaged");
            Bytes block(file_, blocks[i].address, blocks[i].size, "object header");
            while (block.left() >= 8 && messages.size() < count) {
                Message message{block.number(2), false, {}};
                const std::uint64_t size = block.number(2);
                message.is_elsewhere = (block.number(1) & 2U) != 0;
                block.skip(3);
                message.content = block.take(size);
                if (message.type == continuation) {
                    Bytes next(file_, message.content, "object header");
                    const std::uint64_t place = next.number(8);
                    blocks.push_back({place, next.number(8)});
                }
                messages.push_back(std::move(message));
            }
        }
        return messages;
    }

    /// The members of a group, with the addresses of their object headers; `nowhere` for links.
    using Members = std::map<std::string, std::uint64_t>;

    /// Of an array or a group; nothing if it is not there. A symbolic link has no object header.
    std::optional<std::uint64_t> address_of(const std::string& path) const {
        const Members* members = &members_;
        Members of_group;
        for (std::size_t begin = 0;;) {
            const std::size_t end = path.find('/', begin);
            const auto member = members->find(path.substr(begin, end - begin));
            if (member == members->end()) return std::nullopt;
            if (end == std::string::npos) return member->second;
            if (member->second == nowhere) return std::nullopt;
            const std::vector<Message> messages = messages_of(member->second);
            if (find(messages, symbol_table) == nullptr) return std::nullopt;
            of_group = members_of(messages, path.substr(0, end));
            members = &of_group;
            begin = end + 1;
        }
    }

    std::vector<Message> messages_of(const std::string& path) const {
        const std::optional<std::uint64_t> address = address_of(path);
        if (!address) file_.fail(fmt::format("there is no dataset '/{}'", path));
        if (*address == nowhere) fail(path, "it is a link; store the array itself");
        return messages_of(*address);
    }

    static const Message* find(const std::vector<Message>& messages, MessageType type) {
        const auto found = std::ranges::find(messages, std::uint64_t{type}, &Message::type);
        return found == messages.end() ? nullptr : &*found;
    }

    const Message& require(const std::vector<Message>& messages, MessageType type, const std::string& array) const {
        const Message* message = find(messages, type);
        if (message == nullptr) fail(array, "it is no array, or the file is damaged");
        if (message->is_elsewhere) fail(array, "its type is a named one; save it with a type of its own");
        return *message;
    }

    Members members_of(const std::vector<Message>& group, const std::string& name) const {
        const Message* table = find(group, symbol_table);
        if (table == nullptr)
            file_.fail(fmt::format("HDF5: {} has no symbol table; save the field with default settings", name));
        Members members;
        Bytes places(file_, table->content, "symbol table");
        std::vector<std::uint64_t> nodes{places.number(8)};
        const std::string names = heap_at(places.number(8));
        std::uint64_t entries = 0;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (Bytes(file_, nodes[i], 4, "group").take(4) == "SNOD")
                entries += list_members_of(nodes[i], names, members);
            else
                for (const std::uint64_t child : children_of(nodes[i])) nodes.push_back(child);
            if (nodes.size() > most_nodes || entries > most_members)
                places.fail("it has too many members, or the file is damaged");
        }
        return members;
    }

    std::string heap_at(std::uint64_t address) const {
        Bytes heap(file_, address, 32, "heap of names");
        heap.expect("HEAP");
        heap.skip(4);
        const std::uint64_t size = heap.number(8);
        heap.skip(8);
        Bytes names(file_, heap.number(8), size, "heap of names");
        return std::string(names.take(size));
    }

    /// Returns how many there are. Longer names than those of a field's arrays are cut.
    std::uint64_t list_members_of(std::uint64_t address, const std::string& names, Members& members) const {
        Bytes header(file_, address, 8, "group");
        header.skip(6);
        constexpr std::uint64_t entry_size = 40;
        const std::uint64_t count = header.number(2);
        Bytes entries(file_, address + 8, count * entry_size, "group");
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::uint64_t name = entries.number(8);
            const std::uint64_t object = entries.number(8);
            entries.skip(entry_size - 16);
            if (name >= names.size()) entries.fail("a name lies beyond its heap; the file is damaged");
            constexpr std::size_t longest_name = 64;
            const std::string member = names.substr(static_cast<std::size_t>(name), longest_name);
            members.emplace(member.substr(0, member.find('\0')), object);
        }
        return count;
    }

    std::vector<std::uint64_t> children_of(std::uint64_t address) const {
        Bytes header(file_, address, 24, "group");
        header.expect("TREE");
        header.expect(0, 1, "type of nodes");
        header.skip(1);
        const std::uint64_t count = header.number(2);
        Bytes entries(file_, address + 24, 8 + 16 * count, "group");
        std::vector<std::uint64_t> children;
        for (std::uint64_t i = 0; i < count; ++i) {
            entries.skip(8);
            children.push_back(entries.number(8));
        }
        return children;
    }

    std::vector<std::int64_t> shape_of(const std::vector<Message>& messages, const WantedArray& wanted) const {
        const auto shape = dataspace_shape({file_, require(messages, dataspace, wanted.name).content, "shape"});
        if (shape.size() != wanted.axes.size())
            fail(wanted.name,
                 fmt::format("it has not {} dimensions: {}", wanted.axes.size(), fmt::join(wanted.axes, ", ")));
        return {shape.begin(), shape.end()};
    }

    void set_type(StoredArray& array, const std::vector<Message>& messages, const WantedArray& wanted) const {
        const auto type = number_type({file_, require(messages, datatype, wanted.name).content, "type"});
        if (type && type->is_real)
            array.values.type = type->width == 8 ? ElementType::float64 : ElementType::float32;
        else if (type && !type->is_signed && type->width == 4)
            array.values.type = ElementType::uint32;
        else if (type && type->is_signed && type->width == 8)
            array.values.type = ElementType::int64;
        else if (type && !type->is_real && !type->is_signed && type->width == 1)
            array.values.type = ElementType::uint8;
        else
            fail(wanted.name, "its values are neither floats nor doubles nor indices of 8, 32 or 64 bits");
        array.values.order = type->order;
        if (!reads_as(array.values.type, wanted.type))
            fail(wanted.name, fmt::format("{} is of another type", wanted.description));
    }

    /// A B-tree of version 1. Its keys are the chunks' sizes and first values.
    void set_chunks(StoredArray& array, Bytes& message, const std::string& name) const {
        const std::size_t dimensions = array.shape.size();
        if (dimensions > array.chunk_shape.size())
            fail(name, "its values are in chunks; save it contiguous (h5repack -l CONTI)");
        message.expect(dimensions + 1, 1, "number of dimensions");
        std::vector<std::uint64_t> nodes{message.number(8)};
        array.chunk_shape.fill(1);
        std::uint64_t chunk_bytes = bytes_of(array.values.type);
        std::uint64_t expected = 1;
        for (std::size_t i = 0; i < dimensions; ++i) {
            const std::uint64_t edge = array.chunk_shape[i] = message.number(4);
            const auto size = static_cast<std::uint64_t>(array.shape[i]);
            // Later allocations are no larger than the file.
            if (edge == 0 || array.shape[i] < 1 || chunk_bytes > file_.size() / edge ||
                expected > file_.size() / ((size - 1) / edge + 1))
                fail(name, "its chunks do not fit the file, which is truncated or damaged");
            chunk_bytes *= edge;
            expected *= (size - 1) / edge + 1;
        }
        if (expected > file_.size() / chunk_bytes || nodes[0] == nowhere)
            fail(name, "chunks are missing; write every value");
        message.expect(bytes_of(array.values.type), 4, "size of a value");
        for (std::size_t i = 0; i < nodes.size() && array.chunks.size() <= expected; ++i) {
            take_chunks(array, nodes[i], chunk_bytes, nodes);
            if (nodes.size() > 2 * expected + most_nodes) message.fail("it has too many nodes; the file is damaged");
        }
        std::ranges::sort(array.chunks, {}, &StoredArray::Chunk::first);
        const auto twice = std::ranges::adjacent_find(array.chunks, {}, &StoredArray::Chunk::first);
        if (array.chunks.size() != expected || twice != array.chunks.end())
            fail(name, "chunks are missing, or are there twice; write every value");
    }

    void take_chunks(StoredArray& array, std::uint64_t address, std::uint64_t chunk_bytes,
                     std::vector<std::uint64_t>& nodes) const {
        const std::size_t dimensions = array.shape.size();
        Bytes header(file_, address, 24, "chunks");
        header.expect("TREE");
        header.expect(1, 1, "type of nodes");
        const bool is_leaf = header.number(1) == 0;
        const std::uint64_t count = header.number(2);
        Bytes entries(file_, address + 24, count * (8 + 8 * (dimensions + 1) + 8), "chunks");
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::uint64_t bytes = entries.number(4);
            entries.skip(4);  // filter mask; unused, because filters are refused
            StoredArray::Chunk chunk;
            for (std::size_t axis = 0; axis < dimensions; ++axis) chunk.first[axis] = entries.number(8);
            entries.skip(8);
            chunk.offset = entries.number(8);
            if (!is_leaf) {
                nodes.push_back(chunk.offset);
                continue;
            }
            for (std::size_t axis = 0; axis < dimensions; ++axis)
                if (chunk.first[axis] % array.chunk_shape[axis] != 0 ||
                    chunk.first[axis] >= static_cast<std::uint64_t>(array.shape[axis]) || bytes != chunk_bytes)
                    entries.fail("one of them is not where it belongs; the file is damaged");
            array.chunks.push_back(chunk);
        }
    }

    std::optional<Attribute> find_attribute(const std::vector<Message>& messages, const std::string& name) const {
        for (const Message& message : messages) {
            if (message.type != attribute || message.is_elsewhere) continue;
            Bytes bytes(file_, message.content, "attribute");
            const std::uint64_t version = bytes.number(1);
            const std::uint64_t flags = bytes.number(1);
            if (version < 1 || version > 3) bytes.fail(fmt::format("version {} is not known", version));
            const std::uint64_t sizes[] = {bytes.number(2), bytes.number(2), bytes.number(2)};
            if (version == 3) bytes.skip(1);
            const auto take = [&](std::uint64_t size) {
                std::string taken(bytes.take(size));
                if (version == 1) bytes.skip((8 - size % 8) % 8);
                return taken;
            };
            Attribute found;
            found.name = take(sizes[0]);
            found.name.resize(std::min(found.name.find('\0'), found.name.size()));
            if (found.name != name) continue;
            if (version > 1 && flags != 0) bytes.fail("its type is a named one; save it with a type of its own");
            found.type = take(sizes[1]);
            found.shape = take(sizes[2]);
            found.value = bytes.take(bytes.left());
            return found;
        }
        return std::nullopt;
    }

    /// At most one more than any attribute of a field has.
    std::uint64_t count_of(const Attribute& attribute) const {
        constexpr std::uint64_t most_numbers = 9;
        std::uint64_t count = 1;
        for (const std::uint64_t size : dataspace_shape({file_, attribute.shape, "shape of an attribute"}))
            count = size > most_numbers || count > most_numbers ? most_numbers + 1 : count * size;
        return count;
    }

    [[noreturn]] void fail(const std::string& array, const std::string& what) const {
        file_.fail(fmt::format("dataset '/{}': {}", array, what));
    }

    InputFile& file_;
    std::vector<Message> root_;
    Members members_;
};

}  // namespace

std::unique_ptr<Source> open_without_checksums(InputFile& file) {
    return std::make_unique<OldFormat>(file);
}

}  // namespace clsdf::hdf5
