# cmake -DPROGRAM=relight -DVERB="completion;bash" -DPAGE=file -P PrintPage.cmake
# Writes what the program prints, and nothing when it fails or prints nothing.

execute_process(COMMAND ${PROGRAM} ${VERB} OUTPUT_VARIABLE text RESULT_VARIABLE status
                ERROR_VARIABLE errors)
list(JOIN VERB " " verb)
if(NOT status EQUAL 0 OR text STREQUAL "")
  message(FATAL_ERROR "`relight ${verb}` ended with ${status} and printed no page: ${errors}")
endif()
file(WRITE ${PAGE} "${text}")
