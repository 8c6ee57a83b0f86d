# cmake -DOUT=assets.cpp -DFUNCTION=assets -DFILES="a;b" -P embed.cmake
# Writes a function that returns the table of the files' names and bytes, so that the program needs nothing beside itself.
# With -DFOLDERS="a;b" in place of FILES: of all files there that are compressed (.gz).
foreach(folder IN LISTS FOLDERS)
  file(GLOB found ${folder}/*.gz)
  list(APPEND FILES ${found})
endforeach()
set(text "#include \"server/pages/assets.hpp\"\n\nnamespace vacuform {\n\nnamespace {\n")
set(number 0)
foreach(file IN LISTS FILES)
  file(READ ${file} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND text "constexpr unsigned char ${FUNCTION}_${number}[] = {${bytes}0};\n")
  get_filename_component(name ${file} NAME)
  string(APPEND table "    {\"${name}\", {reinterpret_cast<const char*>(${FUNCTION}_${number}), sizeof ${FUNCTION}_${number} - 1}},\n")
  math(EXPR number "${number} + 1")
endforeach()
string(APPEND text "}  // namespace\n\nstd::span<const Asset> ${FUNCTION}() {\n  static const Asset all[] = {\n${table}  };\n"
  "  return all;\n}\n\n}  // namespace vacuform\n")
file(WRITE ${OUT} "${text}")
