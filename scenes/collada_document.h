/// A COLLADA file as XML: elements by id, numbers, errors that name file and element.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "reference/base/error.h"
#include "scenes/affine.h"

namespace scotty::scenes {

class ColladaDocument {
 public:
    /// Throws reference::Error (bad_input) for a file that is not readable, well-formed COLLADA.
    explicit ColladaDocument(std::string path);

    pugi::xml_node root() const { return root_; }
    /// Whether anything in it uses the extras of Scotty3D: profile CMU462, or CGL in the files of
    /// its relatives.
    bool made_for_scotty3d() const;
    /// The element that "#id" points to, inside this file. Throws where there is none, where
    /// it is not one of `kind`, or where several are; `user` is the element that refers to it.
    pugi::xml_node target(pugi::xml_node user, const char* attribute, const char* kind) const;

    /// Whether "#id" is an element of this kind, for references that may be of several.
    bool points_to(pugi::xml_node user, const char* attribute, const char* kind) const;

    /// An error at an element: "scene.dae: <light id="Area">: what".
    reference::Error error(pugi::xml_node element, const std::string& what) const;

    /// All numbers of an element's text. Throws, naming the first thing that is no finite number.
    std::vector<double> numbers(pugi::xml_node element) const;
    /// Exactly `count` numbers.
    std::vector<double> numbers(pugi::xml_node element, std::size_t count) const;
    /// One number, or `standard` where the element is not there.
    double number(pugi::xml_node element, double standard) const;
    /// The first three of an element's three or four numbers.
    Point colour(pugi::xml_node element) const;
    /// An element's text without the blanks around it, or `standard` where it is not there.
    std::string word(pugi::xml_node element, const char* standard) const;
    /// All whole numbers >= 0 of an element's text.
    std::vector<std::uint32_t> indices(pugi::xml_node element) const;
    /// A whole-number attribute, or `standard` where it is not there.
    std::uint32_t count_attribute(pugi::xml_node element, const char* name,
                                  std::uint32_t standard) const;

 private:
    std::string path_;
    pugi::xml_document xml_;
    pugi::xml_node root_;
    std::unordered_map<std::string, std::vector<pugi::xml_node>> by_id_;
};

/// The element below <extra><technique> of profile CMU462 or CGL, empty where there is none.
pugi::xml_node scotty3d_extra(pugi::xml_node element);

}  // namespace scotty::scenes
