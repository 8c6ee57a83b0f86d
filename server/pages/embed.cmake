# cmake -DOUT=assets.cpp -DNAMES="openapi_yaml;style_css" -DFILES="a;b" -P embed.cmake
# Writes functions that return the files' bytes, so that the program needs nothing beside itself.
set(text "#include \"server/pages/assets.hpp\"\n\nnamespace vacuform {\n")
foreach(name file IN ZIP_LISTS NAMES FILES)
  file(READ ${file} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND text "\nstd::string_view ${name}() {\n  static constexpr unsigned char bytes[] = {${bytes}0};\n"
    "  return {reinterpret_cast<const char*>(bytes), sizeof bytes - 1};\n}\n")
endforeach()
string(APPEND text "\n}  // namespace vacuform\n")
file(WRITE ${OUT} "${text}")
