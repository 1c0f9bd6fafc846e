import java.io.EOFException;
import java.io.PrintStream;
import java.lang.reflect.Array;
import java.lang.reflect.Field;
import java.lang.reflect.Modifier;
import java.nio.ByteBuffer;

import lcm.lcm.LCMDataInputStream;
import lcm.logging.Log;
import lcm.spy.LCMTypeDatabase;

/** Prints the messages of a log as lcm-spy decodes them: by the classes on its CLASSPATH. */
public class Decode {
    public static void main(String[] arguments) throws Exception {
        LCMTypeDatabase types = new LCMTypeDatabase();
        PrintStream out = new PrintStream(System.out, true, "UTF-8");
        Log log = new Log(arguments[0], "r");
        while (true) {
            Log.Event event;
            try {
                event = log.readNext();
            } catch (EOFException end) {
                return;
            }
            if (!event.channel.equals(arguments[1])) continue;
            long fingerprint = ByteBuffer.wrap(event.data).getLong();
            Class<?> type = types.getClassByFingerprint(fingerprint);
            Object message = type.getConstructor(java.io.DataInput.class)
                .newInstance(new LCMDataInputStream(event.data));
            out.println(type.getName() + inWords(message));
        }
    }

    private static String inWords(Object value) throws Exception {
        if (value.getClass().isArray()) {
            StringBuilder all = new StringBuilder("[");
            for (int i = 0; i < Array.getLength(value); ++i)
                all.append(i == 0 ? "" : ",").append(inWords(Array.get(value, i)));
            return all.append("]").toString();
        }
        if (!value.getClass().getName().startsWith("weather.")) return value.toString();
        StringBuilder all = new StringBuilder("{");
        for (Field field : value.getClass().getFields()) {
            if (Modifier.isStatic(field.getModifiers())) continue;
            all.append(all.length() == 1 ? "" : ",").append(field.getName()).append("=");
            all.append(inWords(field.get(value)));
        }
        return all.append("}").toString();
    }
}
