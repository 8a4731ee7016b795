#pragma once

#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <vector>

/// A value of JSON. The members of an object keep their order.
///
///     Json result = {{"mesh", file}, {"grid", {{"spacing", grid.spacing}, {"size", grid.size}}}};
///     result["rows"].push_back({{"name", name}, {"limit", nullptr}});
///
/// Null becomes an object when it gets a member, and an array when it gets an element.
class Json {
public:
    struct Member;

    Json() noexcept;  ///< null
    Json(std::nullptr_t) noexcept : Json() {}
    Json(bool truth);
    Json(int number);
    Json(unsigned number);
    Json(long number);
    Json(unsigned long number);
    Json(long long number);
    Json(unsigned long long number);
    Json(double number);  ///< printed as null if it is not finite
    Json(const char* text);
    Json(const std::string& text);
    Json(std::initializer_list<Member> members);  ///< an object

    template <class Value>
    Json(const std::optional<Value>& value) : Json(value ? Json(*value) : Json()) {}

    template <std::ranges::input_range List>
    requires(!std::convertible_to<const List&, std::string_view>) Json(const List& list) : Json(array()) {
        for (const auto& element : list) push_back(element);
    }

    Json(const Json& other);
    Json(Json&& other) noexcept;
    Json& operator=(Json other) noexcept;
    ~Json();

    static Json array();
    static Json object();
    static Json parse(const std::string& text);

    void push_back(Json element);
    /// The member of this name; null if it is new.
    Json& operator[](std::string_view name);
    /// Adds the members of an object, in place of those of the same name.
    void update(const Json& object);

    /// These throw std::exception if the value is of another kind.
    double number() const;
    std::string text() const;
    const std::vector<Json>& elements() const;
    /// Null if there is no such member.
    const Json& operator[](std::string_view name) const;

    /// Indented by two spaces. Bytes that are not UTF-8 are replaced: names of files may have them.
    std::string dump() const;

private:
    struct Content;
    explicit Json(Content content);

    std::unique_ptr<Content> content_;  ///< nothing for null
};

struct Json::Member {
    std::string name;
    Json value;
};
