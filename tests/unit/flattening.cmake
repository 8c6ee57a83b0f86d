vacuform_test(flattening_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/flattening_test.cpp LINKS vacuform_flattening)
